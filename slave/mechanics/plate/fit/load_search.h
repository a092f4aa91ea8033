// Finds the coarse position of a load on a plate: the best of 91 positions, using the
// small-deflection shape. Nondimensional as in green.h.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/green.h"

namespace palpate::plate {

class LoadSearch {
 public:
  // Loads over discs of `load_radius`, their centres up to `farthest` from the plate's.
  LoadSearch(double load_radius, double farthest);

  // The shapes at these points; no work if they are those of the last call. Allocates.
  void SetPoints(std::span<const Eigen::Vector2d> points);

  struct Found {
    Eigen::Vector2d place{0, 0};
    double deflection = 0;  // force at the position, in the unit of the values
    double explained = 0;   // of the sum of squared weighted values
  };
  // `values` of the deflections at the points times their `weights`. The part that the orthonormal
  // columns of `left_out` explain does not count, if there are any. Only positions up to
  // `farthest`. No allocation.
  [[nodiscard]] Found Best(const Eigen::VectorXd& values, const Eigen::VectorXd& weights,
                           const Eigen::Matrix<double, Eigen::Dynamic, 3>* left_out,
                           double farthest) noexcept;

 private:
  std::vector<Disc> places_;
  std::vector<double> under_load_;  // deflection at the position itself under a unit load
  std::vector<Eigen::Vector2d> points_;
  Eigen::MatrixXd shapes_;  // one column per position
  Eigen::VectorXd shape_;
};

// Motions of a plate's rim, along z and tilted, that displacements of points contain: their part is
// removed from measured and fitted displacements.
class RimMotions {
 public:
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  // `places`: positions of the points [radii]; `sigmas`: of their displacements [m]. Motions that
  // the points cannot distinguish are left out. Allocates for more points than before.
  void Span(std::span<const Eigen::Vector2d> places, std::span<const double> sigmas);
  // Orthonormal motions, as displacements divided by their sigmas.
  [[nodiscard]] const Columns& columns() const { return columns_; }
  void LeaveOut(Eigen::VectorXd* values) const noexcept;
  // c0 + c1 x + c2 y along z that explains the values best.
  [[nodiscard]] Eigen::Vector3d In(const Eigen::VectorXd& values) const noexcept {
    return motions_ * (columns_.transpose() * values);
  }

 private:
  Columns columns_;
  Eigen::Matrix3d motions_ = Eigen::Matrix3d::Identity();  // one column per motion
};

}  // namespace palpate::plate
