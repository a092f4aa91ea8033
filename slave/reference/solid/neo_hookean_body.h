// Elastic forces and stiffness of neo-Hookean rubber divided into elements of any shape.
//
// Nondimensional: stresses are divided by E; lengths are in the unit of the elements. Total
// Lagrangian; only displacements are unknowns, because quadratic and cubic elements do not lock.
// Const members are thread-safe.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/sparse_ldlt.h"
#include "slave/reference/solid/element_shape.h"

namespace palpate::simulation {

// Nearly incompressible rubber, stretched at rest or not:
//
//   W(F) = mu / 2 (J^(-2/3) tr F^T F - 3) + K / 2 (J - 1)^2,   J = det F
//   mu = E / (2 (1 + nu)),   K = E / (3 (1 - 2 nu))
//
// per volume of the rubber free of stress (Bonet and Wood, Nonlinear Continuum Mechanics, 2008,
// 6.5). Stresses by E. Immutable, hence thread-safe.
class NeoHookean {
 public:
  // First Piola-Kirchhoff stress, per area at rest, and its derivative over vec(F), column by
  // column.
  struct Stress {
    Eigen::Matrix3d P;
    Eigen::Matrix<double, 9, 9> tangent;
  };

  // -1 < nu < 0.5. `tension` >= 0: stress in the plane of a sheet at rest, none across it.
  NeoHookean(double nu, double tension);

  // At H = F - I with F from the rest, so that small strains keep their digits. False: not J > 0.
  bool At(const Eigen::Matrix3d& H, bool with_tangent, Stress* stress) const;

 private:
  bool FromFree(const Eigen::Matrix3d& H, bool with_tangent, Stress* stress) const;
  [[nodiscard]] double Stretched(double along, double across, int component) const;

  double mu_, bulk_;
  Eigen::Vector3d stretch_{1, 1, 1};  // from free to the rest, in the plane and across
};

class NeoHookeanBody {
 public:
  using Matrix = SparseLdlt<double>::Matrix;

  // Nodes from `free_nodes` on stay where they are and have no unknowns.
  NeoHookeanBody(std::vector<PlacedElement> elements, int free_nodes, const NeoHookean& rubber);

  // Unknowns: x, y, z of node by node.
  [[nodiscard]] int size() const { return 3 * static_cast<int>(upper_.size()); }
  // Computes the elastic forces at displacements u. False: an element is inverted.
  bool Forces(const Eigen::VectorXd& u, Eigen::VectorXd* forces) const;
  // Also computes their derivatives: the upper triangle, with the pattern of EmptyMatrix().
  bool Linearise(const Eigen::VectorXd& u, Eigen::VectorXd* forces, Matrix* stiffness) const;
  [[nodiscard]] Matrix EmptyMatrix() const;
  // Rows and columns of unknowns that are not `free` (0 or 1, each) become those of the identity.
  static void Hold(const Eigen::VectorXd& free, Matrix* stiffness);

 private:
  struct Work;

  void FindPattern();
  [[nodiscard]] bool has_unknowns(int node) const { return node < static_cast<int>(upper_.size()); }
  bool Accumulate(const Eigen::VectorXd& u, Eigen::VectorXd* forces, Matrix* stiffness) const;
  bool Integrate(const PlacedElement& element, const Eigen::VectorXd& u, bool with_stiffness,
                 Work* work) const;
  void AddForces(const PlacedElement& element, const Work& work, Eigen::VectorXd* forces) const;
  void AddStiffness(std::size_t element, const Work& work, Matrix* stiffness) const;

  std::vector<PlacedElement> elements_;
  NeoHookean rubber_;
  std::vector<std::vector<int>> upper_;  // per free node: those up to it that it couples with
  // Per element: of the block between its nodes i and j in the columns of the latter, i + nodes j.
  std::vector<std::vector<int>> positions_;
};

}  // namespace palpate::simulation
