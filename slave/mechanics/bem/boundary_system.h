// The equations of the boundary element method: H u = G t, collocated at the elements' nodes.
//
// Every unknown is in the column of its node and component: A_0 Y + Abar_0 Ybar = 0 with the
// columns of H and G sorted by the quantities that the reference problem prescribes.
// Nondimensional: lengths are divided by the mesh's unit, tractions by E.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem/element_nodes.h"
#include "slave/mesh/outline.h"
#include "slave/program/progress.h"
#include "slave/scene/scene.h"

namespace palpate {

// The constants of a plane problem over Young's modulus. Plane stress is plane strain with the
// effective nu / (1 + nu) and the same shear modulus.
struct PlaneElasticity {
  double shear_modulus = 0;  // G / E [-]
  double effective_nu = 0;   // [-]
  // Throws std::invalid_argument unless -1 < nu <= 0.5.
  static PlaneElasticity From(double nu, Plane plane);
};

// Boundary conditions of the reference problem: zero displacement on the fixed part, zero traction
// on the rest.
struct ReferenceProblem {
  BoundaryMesh mesh;                      // [m]
  std::vector<std::array<bool, 2>> held;  // per element: x, y
  double nu = 0;                          // Poisson ratio [-]
  Plane plane = Plane::kStress;
  ElementOrder order = ElementOrder::kConstant;
};

struct BoundaryNode {
  Eigen::Vector2d p_O;  // [m]
  int element = 0;
  double length = 0;  // length of the boundary that belongs to it: its weight times the element's
                      // [length units]
};

// Element by element, along the boundary.
std::vector<BoundaryNode> NodesOf(const ReferenceProblem& problem);

class BoundarySystem {
 public:
  // Stores references to both.
  BoundarySystem(const ReferenceProblem& problem, const std::vector<BoundaryNode>& nodes,
                 const PlaneElasticity& elasticity)
      : problem_(problem), nodes_(nodes), elasticity_(elasticity) {}

  // The upper left corners of A_0 and of -Abar_0, two rows and columns for each node. O(N^2).
  // Throws Interrupted.
  void Collocate(Eigen::MatrixXd* A, Eigen::MatrixXd* Abar, Progress* progress) const;

  // Computes displacements at `places` in the body [m] by Somigliana's identity: G t - H u with the
  // nodes' values, all nondimensional; two rows for each place. The integrals are exact, so that
  // the steps of constant elements appear only closer to the boundary than an element's length.
  void Inside(const std::vector<Eigen::Vector2d>& places, Eigen::MatrixXd* H,
              Eigen::MatrixXd* G) const;

  // Holes in a body that hardly changes its volume. At nu = 0.5 the collocated equations admit, for
  // each hole, any pressure that acts in the hole and on its boundary; below it the equations
  // determine it with an error that grows as 1 / (1 - 2 nu). In the hole Somigliana's identity
  // gives zero, and its divergence, divided by 1 - 2 nu, the pressure,
  //   int (r,j / r) t_j ds - 2 G int ((n_j - 2 r,j dr/dn) / r^2) u_j ds = 0,
  // holds for every nu. One such row per hole, at its centre, determines the pressure. Column and
  // row `first` + hole; the column's unknown, tractions along the normal at the hole's nodes,
  // vanishes with the discretisation error.
  void AppendHolePressures(Eigen::Index first, Eigen::MatrixXd* A, Eigen::MatrixXd* Abar) const;
  [[nodiscard]] int holes() const { return static_cast<int>(problem_.mesh.loop_begin.size()) - 2; }

 private:
  void CollocateElement(int element, Eigen::MatrixXd* A, Eigen::MatrixXd* Abar) const;
  [[nodiscard]] bool held(std::size_t element, int c) const {
    return problem_.held[element][static_cast<std::size_t>(c)];
  }

  const ReferenceProblem& problem_;
  const std::vector<BoundaryNode>& nodes_;
  const PlaneElasticity& elasticity_;
};

// Returns the view of the element from `p_O` [m].
struct ElementView ViewOf(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& p_O);

}  // namespace palpate
