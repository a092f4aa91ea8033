// A cloud of points without names beside the surface of a loaded organ: how far each is from it,
// and the normal equations for the load. A point tells how far the surface is along its normal and
// nothing of where along the surface it was.
//
//   e_j = n_j . (y_j - x(b_j)),   x = X + sum_k z_k B_k F,   z_0 = 1
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/pipeline/organ/moving_surface.h"
#include "slave/pipeline/organ/patch_greens.h"

namespace palpate {

// Unknowns: the force [N], then what the field has columns for: shifts along the surface [m], log
// of the width, stiffness modes.
inline constexpr int kLoadUnknowns = 2 + PatchGreens::kColumns;
using LoadVector = Eigen::Matrix<double, kLoadUnknowns, 1>;
using LoadMatrix = Eigen::Matrix<double, kLoadUnknowns, kLoadUnknowns>;

struct CloudSquares {
  LoadMatrix H = LoadMatrix::Zero();  // of weighted squares, in units of scatter
  LoadVector g = LoadVector::Zero();  // H step = g
  double scatter = 0;   // robust standard deviation of a point, at least the sensor's [m]
  double rms = 0;       // of all used points [m]
  double distance = 0;  // rms of all points from the surface, those beyond its border too [m]
  double moved = 0;     // rms displacement of the surface under them [m]
  double effect = 1;    // by which neighbours that err alike make errors larger, of variances
  int used = 0;         // points; those beyond the border are not
};

// Not thread-safe.
class CloudFit {
 public:
  // `watched`: nodes at rest, and triangles of them. `sigma` of a point [m].
  CloudFit(const std::vector<Eigen::Vector3d>& watched, std::vector<std::array<int, 3>> triangles,
           double sigma);

  // At load `u`. Allocation-free after the first call with as many points.
  const CloudSquares& Linearise(std::span<const Eigen::Vector3d> points_O,
                                const PatchGreens::Field& field, const LoadVector& u) noexcept;

 private:
  void Deform(const PatchGreens::Field& field, const LoadVector& u) noexcept;
  void Add(const MovingSurface::Place& place, const PatchGreens::Field& field,
           const Eigen::Matrix<float, PatchGreens::kColumns, 1>& z, double weight) noexcept;
  [[nodiscard]] double Scatter() noexcept;
  void Cluster() noexcept;

  MovingSurface::Nodes rest_, moved_;
  MovingSurface surface_;
  double sigma_;
  std::vector<int> cell_;                                                 // per triangle
  Eigen::Matrix<float, PatchGreens::kColumns, Eigen::Dynamic> by_force_;  // B_k F, three per node
  std::vector<MovingSurface::Place> places_;
  std::vector<double> sorted_;
  std::vector<double> sums_;  // per cell
  CloudSquares squares_;
};

}  // namespace palpate
