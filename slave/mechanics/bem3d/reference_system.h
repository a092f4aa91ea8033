// The boundary element system of a body under the reference boundary conditions: fixed components
// stand still, everything else is free of traction (paper A, eqs. 3-6, for solids).
//
// Tractions are constant on each triangle, displacements linear: their values at the centroids are
// the unknowns, those at the corners follow from the triangles around (CornerFit). Collocated at
// the centroids: H P = G V, H = I / 2 + principal values of the traction kernel. The columns of H
// and G are sorted by what is unknown, A_0 Y + Abar_0 Ybar = 0. A body that is not fixed against
// all rigid motions gets six more unknowns and rows, as in 2D: the amplitudes of balancing
// tractions, and zero mean displacement and turn, weighted by area.
//
// Nondimensional: lengths by the surface's length unit, tractions by E.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem3d/closed_surface.h"
#include "slave/mechanics/bem3d/kelvin_triangle.h"

namespace palpate {

class ReferenceSystem {
 public:
  // Largest Poisson ratios of bodies whose pressure the boundary integrals lose near 0.5, as in 2D
  // (GreensFunctions): with cavities (a thick shell under inner pressure is off by 8 % with 360
  // triangles, by 3 % with 1000; at 0.49 by 66 and 17 %), and fixed all around.
  static constexpr double kLargestNuWithCavities = 0.45;
  static constexpr double kLargestNuAllHeld = 0.499;

  // `held`: per triangle, components x, y, z. Throws std::invalid_argument: the surface (see
  // ClosedSurface), not one entry per triangle, nu out of range or too near 0.5.
  ReferenceSystem(const SurfaceMesh& mesh, HeldNodes held, double nu);

  [[nodiscard]] int triangles() const { return surface_.size(); }
  // Unknowns: three per triangle, six more where the body is free to move.
  [[nodiscard]] int order() const { return 3 * triangles() + (free_motions_ > 0 ? 6 : 0); }

  // A_0. Calls `before(i)` now and then before the rows of triangle i; it may throw. O(N^2)
  // integrals.
  [[nodiscard]] Eigen::MatrixXd Matrix(const std::function<void(int)>& before) const;
  // Its rows of the triangles [begin, end), three each; fastest with kRows triangles.
  static constexpr int kRows = 16;  // they stay in the processor's cache
  [[nodiscard]] Eigen::MatrixXd Rows(int begin, int end) const;
  // Its last six rows, where the body is free to move.
  [[nodiscard]] Eigen::MatrixXd MeanMotions() const;
  // -Abar_0 by a unit force, spread evenly, along each component of the triangles [begin, end):
  // three columns each, zero where it is fixed.
  [[nodiscard]] Eigen::MatrixXd Loads(int begin, int end) const;

  // The corners of a triangle, counted as in CornerFit, and what the displacements at the centroids
  // come to in one.
  [[nodiscard]] const std::array<int, 3>& corners(int triangle) const {
    return fit_.corners(triangle);
  }
  [[nodiscard]] Eigen::Vector3d AtCorner(int corner,
                                         const std::vector<Eigen::Vector3d>& displacement) const;

  // A fixed triangle counts with its centroid: a single one does not hold against turning. 0: the
  // body is fixed.
  [[nodiscard]] int free_motions() const { return free_motions_; }
  // Displacement at `p` (nondimensional) by a unit amplitude of each rigid motion that is left
  // free, one column each, zero beyond free_motions().
  [[nodiscard]] Eigen::Matrix<double, 3, 6> RigidModes(const Eigen::Vector3d& p) const;

  [[nodiscard]] const ClosedSurface& surface() const { return surface_; }
  [[nodiscard]] const HeldNodes& held() const { return held_; }
  [[nodiscard]] bool held(int i, int component) const {
    return held_[static_cast<std::size_t>(i)][static_cast<std::size_t>(component)];
  }
  [[nodiscard]] double nu() const { return nu_; }

 private:
  void RequireCompressible() const;
  void FindFreeMotions();
  void MarkHeldNodes();
  void FillRows(int begin, int end, Eigen::MatrixXd* rows, Eigen::MatrixXd* by_node) const;
  void ShareNodes(const Eigen::MatrixXd& by_node, Eigen::MatrixXd* rows) const;
  [[nodiscard]] KelvinSolidBlocks Blocks(int i, int j) const;

  ClosedSurface surface_;
  CornerFit fit_;
  HeldNodes held_;
  HeldNodes held_nodes_;  // those of fixed triangles
  double nu_;
  KelvinSolidConstants constants_;
  Eigen::Vector3d mean_{0, 0, 0};  // of the surface
  Eigen::Matrix<double, 6, 6> motions_ =
      Eigen::Matrix<double, 6, 6>::Identity();  // shifts, turns about the mean; free ones first
  int free_motions_ = 6;
};

}  // namespace palpate
