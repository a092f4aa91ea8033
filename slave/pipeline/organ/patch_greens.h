// How an organ's seen surface moves under a load over a patch of unknown place and width, and under
// small errors of its stiffness.
//
//   u = K^-1 f,   f_i = w_i F,   w_i ~ a_i exp(-|X_i - c|^2 / (2 s^2)),   sum w_i = 1,
//   d u / d theta_m = -K^-1 K_m u,   E(x) = E (1 + sum theta_m phi_m(x)),   sum phi_m = 1
#pragma once

#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/green/tet_stiffness.h"
#include "slave/mechanics/linear/mumps.h"

namespace palpate {

// A load spread over the surface around a place, frame O.
struct LoadPatch {
  Eigen::Vector3d p_O{0, 0, 0};                                       // c, on the surface [m]
  Eigen::Vector3d n_O{0, 0, 1}, along_O{1, 0, 0}, across_O{0, 1, 0};  // unit, normal and tangents
  double width = 0;                                                   // s [m]
  // Its mean displacement, weighted as the load, by a force [m/N]; once pressed.
  Eigen::Matrix3d compliance_O = Eigen::Matrix3d::Zero();
};

// Linear tetrahedra, small strain (tet_stiffness.h). Not thread-safe.
class PatchGreens {
 public:
  // Columns of a field: the patch itself, its derivatives along `along_O` and `across_O` [1/m] and
  // by log s, then by theta.
  static constexpr int kShifts = 3, kModes = 12, kColumns = 1 + kShifts + kModes;
  // Nine entries per watched node, 3 r + c: displacement along r by a newton along c [m/N].
  using Field = Eigen::Matrix<float, kColumns, Eigen::Dynamic>;

  // `watched`: nodes whose displacements are asked for. Throws as AssembleTetStiffness and
  // SpdFactor do.
  PatchGreens(const SolidMesh& mesh, const HeldNodes& held, double young_modulus,
              double poisson_ratio, std::vector<int> watched);

  // The first 1 + kShifts columns: a sparse solution for twelve right-hand sides.
  void Press(LoadPatch* patch, Field* field);
  // The others, for the patch of the last load: 36 right-hand sides.
  void Soften(Field* field);
  // Column 0 alone of several patches: a vector each.
  [[nodiscard]] std::vector<Eigen::VectorXf> PressEach(std::vector<LoadPatch>* patches);

  // The patch around a place of the surface.
  [[nodiscard]] LoadPatch PatchAt(const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O,
                                  double width) const;
  // Some node near it can move.
  [[nodiscard]] bool CanPress(const LoadPatch& patch) const;
  [[nodiscard]] const SurfaceMesh& surface() const { return surface_; }
  [[nodiscard]] const std::vector<int>& watched() const { return watched_; }
  // Nodes of the surface that can move, far from each other, first the farthest: all within the
  // returned spacing of one of them.
  [[nodiscard]] std::vector<int> Spread(int count, double* spacing) const;
  [[nodiscard]] const Eigen::Vector3d& normal(int node) const {
    return normals_[static_cast<std::size_t>(node)];
  }

 private:
  void PlaceModes();
  [[nodiscard]] bool IsHeld(int node) const;  // or a component of it
  // Weights of the surface's nodes, and their derivatives as in Field.
  [[nodiscard]] Eigen::MatrixXd Weights(const LoadPatch& patch) const;
  void AddRow(int node, int axis, double value, Eigen::Index column, Eigen::MatrixXd* right) const;
  [[nodiscard]] Eigen::Matrix3d ComplianceOf(const Eigen::MatrixXd& solved, Eigen::Index from,
                                             const Eigen::MatrixXd& weights) const;
  void Keep(const Eigen::MatrixXd& solved, Eigen::Index from, int column, Field* field) const;
  [[nodiscard]] double Solution(const Eigen::MatrixXd& solved, int node, int axis,
                                Eigen::Index column) const;

  const SolidMesh mesh_;
  SurfaceMesh surface_;
  std::vector<int> watched_;
  double lambda_, mu_;  // of E [Pa]
  double unit_;         // E L [N/m]
  TetStiffness stiffness_;
  SpdFactor factor_;
  std::vector<int> skin_;                 // nodes of the surface
  std::vector<double> area_;              // per node [m^2]
  std::vector<Eigen::Vector3d> normals_;  // per node
  Eigen::MatrixXd modes_;                 // phi, tets x kModes
  Eigen::MatrixXd pressed_;               // solution of the patch last pressed [m/N]
};

}  // namespace palpate
