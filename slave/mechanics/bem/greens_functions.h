// Green's functions of a planar elastic body: what every boundary element does to every other one
// under the reference boundary conditions (paper A, eqs. 3-6; James and Pai 2003).
//
// Constant elements: H P = G V, H = I / 2 + principal values of the traction kernel, collocated at
// the elements' midpoints. The columns of H and G are sorted by what is unknown in the reference
// problem, A_0 Y + Abar_0 Ybar = 0, and E = -A_0^-1 Abar_0 maps what is prescribed to what is not:
// tractions to displacements where the body is free, displacements to reactions where it is held.
//
// Nondimensional inside: lengths by the mesh's length unit, tractions by E.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/outline.h"
#include "shared/scene/scene.h"

namespace palpate {

// The constants of a plane problem over Young's modulus. Plane stress is plane strain with the
// effective nu / (1 + nu) and the same shear modulus.
struct PlaneElasticity {
  double shear_modulus = 0;  // G / E [-]
  double effective_nu = 0;   // [-]
  // Throws std::invalid_argument unless -1 < nu <= 0.5.
  static PlaneElasticity From(double nu, Plane plane);
};

// What the reference problem holds at zero displacement; everything else is free of traction.
struct ReferenceProblem {
  BoundaryMesh mesh;                      // [m]
  std::vector<std::array<bool, 2>> held;  // per element: x, y
  double nu = 0;                          // Poisson ratio [-]
  Plane plane = Plane::kStress;
};

class GreensFunctions {
 public:
  // Largest Poisson ratio in plane strain for a body with holes. The closed integral of u . n over
  // a hole's boundary vanishes from H and G with 1 - 2 nu, and with it what a hole's pressure does;
  // the discretisation error grows as 1 / (1 - 2 nu): 5 % at 0.49 with 60 elements on the hole. The
  // flux row over the whole boundary is no cure: the lost solution satisfies it.
  static constexpr double kLargestNuWithHoles = 0.49;
  // Largest Poisson ratio in plane strain when displacements are prescribed on the whole boundary:
  // the pressure level is then known only through 1 / (1 - 2 nu).
  static constexpr double kLargestNuAllHeld = 0.499;

  // Assembles and solves: O(N^3), N elements. Throws std::invalid_argument: fewer than three
  // elements, elements without length, nu out of range or too near 0.5 (see above), a system that
  // is singular to working precision.
  explicit GreensFunctions(ReferenceProblem problem);

  // The 2x2 block of E, column-major: what element `j`'s prescribed components do at element `i`.
  // One cache line at most, blocks of one column `j` lie one after the other.
  [[nodiscard]] const double* block(int i, int j) const {
    return blocks_.data() +
           4 * (static_cast<std::size_t>(j) * stride_ + static_cast<std::size_t>(i));
  }

  // A body that is not held against all rigid motions gets two more blocks, [size(),
  // block_count()): prescribed are the mean rigid motions (zero in the reference), unknown the
  // balancing tractions, amplitude by mode, that a load which is not balanced would need.
  [[nodiscard]] int size() const { return static_cast<int>(problem_.held.size()); }
  [[nodiscard]] int block_count() const { return static_cast<int>(stride_); }
  // The displacement at `p_O` [m] by a unit amplitude of each rigid motion that is left free, one
  // column each, zero beyond free_motions().
  [[nodiscard]] Eigen::Matrix<double, 2, 3> RigidModes(const Eigen::Vector2d& p_O) const noexcept;
  // 0: the body is held. An element that is held counts with both its ends, so that a single one
  // holds against rotation too.
  [[nodiscard]] int free_motions() const { return free_motions_; }

  [[nodiscard]] const ReferenceProblem& problem() const { return problem_; }  // mesh [m]
  [[nodiscard]] const PlaneElasticity& elasticity() const { return elasticity_; }
  [[nodiscard]] const std::vector<double>& lengths() const { return lengths_; }  // [length units]
  [[nodiscard]] bool held(int i, int component) const {
    return problem_.held[static_cast<std::size_t>(i)][static_cast<std::size_t>(component)];
  }
  [[nodiscard]] double condition() const { return condition_; }  // of A_0, 1-norm estimate
  [[nodiscard]] std::size_t memory_bytes() const { return blocks_.size() * sizeof(double); }

 private:
  void FindFreeMotions();
  void Assemble(Eigen::MatrixXd* A, Eigen::MatrixXd* Abar) const;
  void AppendFreeMotions(Eigen::MatrixXd* A, Eigen::MatrixXd* Abar) const;
  void StoreBlocks(const Eigen::MatrixXd& E);

  ReferenceProblem problem_;
  PlaneElasticity elasticity_;
  std::vector<double> lengths_;
  Eigen::Vector2d mean_p_O_{0, 0};  // of the boundary [m]
  Eigen::Matrix3d motions_ =
      Eigen::Matrix3d::Identity();  // x, y, turn about the mean; free ones first
  int free_motions_ = 0;
  std::size_t stride_ = 0;
  std::vector<double> blocks_;
  double condition_ = 0;
};

}  // namespace palpate
