#include "master/motion/axis_wizard.h"

#include <array>

namespace palpate {
namespace {

constexpr std::array<const char*, 3> kMotions{"to the right", "up", "forward, away from you"};
constexpr double kClear = 2;  // times as far along one axis as along the others

}  // namespace

std::string AxisWizard::Add(const Eigen::Vector3d& p_D, double t) {
  if (axes_) return {};
  if (!from_ || (waits_ && (p_D - *from_).norm() > kStill)) {
    const bool is_first = !from_;
    from_ = p_D;
    rests_since_ = t;
    if (is_first) return "Hold the device still.";
  }
  if (!waits_) return Judge(p_D - *from_);
  if (t - rests_since_ < kRest) return {};
  waits_ = false;
  return std::string("Move the device ") + kMotions[static_cast<std::size_t>(step_)] + ".";
}

std::string AxisWizard::Judge(const Eigen::Vector3d& way) {
  int axis = 0;
  const double along = way.cwiseAbs().maxCoeff(&axis);
  if (along < kTravel) return {};
  waits_ = true;
  Eigen::Vector3d across = way.cwiseAbs();
  across[axis] = 0;
  if (along < kClear * across.maxCoeff()) {
    return "That was along no single axis of the device. Hold it still, and try again.";
  }
  if (!P_.col(axis).isZero(0)) {
    return "That was along the axis of an earlier motion. Hold the device still, and try again.";
  }
  const double sign = (way[axis] > 0 ? 1 : -1) * (step_ == 2 ? -1 : 1);
  P_(step_++, axis) = sign;
  if (step_ == 3) axes_ = AxisMap(P_);
  return "Good. Hold the device still.";
}

}  // namespace palpate
