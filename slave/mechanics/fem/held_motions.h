// Finds the rigid motions of a connected part of a body that supports and contacts do not prevent.
// All models of volumes use this search.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate::fem {

class HeldMotions {
 public:
  // Translation, then rotation about the centre of the part's box, by half the box's diagonal.
  using Motion = Eigen::Matrix<double, 6, 1>;
  using Motions = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;

  explicit HeldMotions(const Eigen::AlignedBox3d& part)
      : centre_(part.center()), radius_(0.5 * part.diagonal().norm()) {}

  // Displacement component `c` of a point under each unit motion.
  [[nodiscard]] Motion Row(const Eigen::Vector3d& point, int c) const {
    Motion row;
    row << Eigen::Vector3d::Unit(c), ((point - centre_) / radius_).cross(Eigen::Vector3d::Unit(c));
    return row;
  }
  // Holds one displacement component, or a weighted sum of components, given by its row.
  void Hold(const Motion& row) { gram_ += row * row.transpose(); }
  // Returns an orthonormal basis of the remaining motions.
  [[nodiscard]] Motions Free() const;

 private:
  Eigen::Vector3d centre_;
  double radius_;
  Eigen::Matrix<double, 6, 6> gram_ = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace palpate::fem
