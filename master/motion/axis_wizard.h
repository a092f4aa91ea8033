// Finds the axes of a device from three motions of the operator: right, up, forward.
//
// Each motion counts once the device has rested, from where it rested, when it has moved by kTravel
// and twice as far along one axis as along the others. Forward is away from the operator, against
// z of M.
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "master/motion/axis_map.h"

namespace palpate {

class AxisWizard {
 public:
  static constexpr double kTravel = 0.015;  // [m]
  static constexpr double kRest = 0.5;      // time without motion before each motion [s]
  static constexpr double kStill = 0.001;   // smaller changes are no motion [m]

  // Takes the device's position `p_D` [m] at `t` [s]. Returns a sentence for the operator; empty:
  // nothing new.
  std::string Add(const Eigen::Vector3d& p_D, double t);
  // Set after the three motions.
  [[nodiscard]] const std::optional<AxisMap>& axes() const { return axes_; }

 private:
  std::string Judge(const Eigen::Vector3d& way);

  int step_ = 0;  // 0: right, 1: up, 2: forward
  Eigen::Matrix3d P_ = Eigen::Matrix3d::Zero();
  std::optional<AxisMap> axes_;
  bool waits_ = true;  // for rest
  std::optional<Eigen::Vector3d> from_;
  double rests_since_ = 0;  // [s]
};

}  // namespace palpate
