#include "master/device/turn_passivity.h"

namespace palpate {

void TurnPassivity::Observe(const Eigen::Quaterniond& q, const Eigen::Vector3d& t,
                            bool engaged) noexcept {
  const Eigen::AngleAxisd turn(has_last_ ? q * last_.conjugate() : Eigen::Quaterniond::Identity());
  turned_ = turn.angle() * turn.axis();
  last_ = q;
  has_last_ = true;
  balance_ -= t.dot(turned_);
  if (t.isZero(0)) balance_ = std::min(balance_, 0.0);
  if (engaged && !engaged_) balance_ = std::max(balance_, 0.0);
  engaged_ = engaged;
}

Eigen::Vector3d TurnPassivity::Apply(const Eigen::Vector3d& t) const noexcept {
  const double size = turned_.norm(), along = t.dot(turned_);
  if (balance_ >= -kEnergyCredit || !(along > 0)) return t;
  return t - along / (size * size) * turned_;
}

}  // namespace palpate
