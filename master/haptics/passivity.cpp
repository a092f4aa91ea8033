#include "master/haptics/passivity.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr double kSlowest = 1e-4;  // no damping below: noise has no direction [m/s]

}  // namespace

void PassivityControl::Observe(const Eigen::Vector3d& p_M, const Eigen::Vector3d& f_M,
                               double dt) noexcept {
  const Eigen::Vector3d dp = moved_ ? Eigen::Vector3d(p_M - last_p_) : Eigen::Vector3d(0, 0, 0);
  last_p_ = p_M;
  moved_ = true;
  const double work = -f_M.dot(dp);
  (work > 0 ? energy_in_ : energy_out_) += std::abs(work);
  const bool shown = f_M != Eigen::Vector3d::Zero();
  balance_ = shown ? balance_ + work + kPhysicalDamping * dp.squaredNorm() / dt : 0;
  min_ = std::min(min_, balance_);
}

Eigen::Vector3d PassivityControl::Apply(const Eigen::Vector3d& f_M, const Eigen::Vector3d& v_M,
                                        double dt) const noexcept {
  const double speed = v_M.norm();
  if (balance_ >= 0 || speed < kSlowest) return f_M;
  const double alpha = std::min(-balance_ / (dt * speed * speed), kMaxDamping);
  const double size = std::min(alpha * speed, f_M.norm());
  return f_M - size / speed * v_M;
}

}  // namespace palpate
