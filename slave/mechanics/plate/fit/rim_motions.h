// Motions of a plate's rim, along z and tilted, that displacements of points contain: what they
// explain is taken out of measured and fitted displacements alike.
#pragma once

#include <span>

#include <Eigen/Core>

namespace palpate::plate {

class RimMotions {
 public:
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  // `places`: of the points [radii]; `sigmas` of their displacements [m]. Motions that the points
  // cannot tell apart are left out. Allocates for more points than before.
  void Span(std::span<const Eigen::Vector2d> places, std::span<const double> sigmas);
  // Orthonormal, as displacements by their sigmas.
  [[nodiscard]] const Columns& columns() const { return columns_; }
  void LeaveOut(Eigen::VectorXd* values) const noexcept;
  // c0 + c1 x + c2 y along z that explains the values best.
  [[nodiscard]] Eigen::Vector3d In(const Eigen::VectorXd& values) const noexcept {
    return motions_ * (columns_.transpose() * values);
  }

 private:
  Columns columns_;
  Eigen::Matrix3d motions_ = Eigen::Matrix3d::Identity();  // by the columns' shares
};

}  // namespace palpate::plate
