#include "master/haptics/force_chain.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr std::array<std::string_view, kReasonCount> kNames{
    "not_following", "stale",     "unknown", "other_epoch", "fading",    "punctured", "blending",
    "beyond_model",  "passivity", "clamped", "not_finite",  "bad_state", "bad_device"};

constexpr double kSlowest = 1e-4;  // no damping below: noise has no direction [m/s]

}  // namespace

std::string_view ToString(Reason reason) {
  return kNames[static_cast<std::size_t>(reason)];
}

std::string ToString(const Reasons& reasons) {
  std::string text;
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    if (!reasons.Has(static_cast<Reason>(i))) continue;
    if (!text.empty()) text += '+';
    text += kNames[i];
  }
  return text;
}

Eigen::Vector3d LimitForce(const Eigen::Vector3d& force, double limit, Reasons* reasons) noexcept {
  if (!force.allFinite() || !(limit >= 0)) {
    reasons->Add(Reason::kNotFinite);
    return {0, 0, 0};
  }
  const double size = force.stableNorm();  // squares of 1e300 overflow
  if (size <= limit) return force;
  reasons->Add(Reason::kClamped);
  return force / size * limit;
}

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

void OutputBlend::Go(Target target, double duration) noexcept {
  target_ = target;
  from_ = sent_;
  duration_ = duration;
  elapsed_ = 0;
}

Eigen::Vector3d OutputBlend::Step(const Eigen::Vector3d& rendered, double dt) noexcept {
  elapsed_ += dt;
  Eigen::Vector3d wanted(0, 0, 0);
  if (target_ == Target::kRendered) wanted = rendered;
  if (target_ == Target::kFrozen) wanted = from_;
  const double share = is_blending() ? elapsed_ / duration_ : 1;
  sent_ = from_ + share * (wanted - from_);
  if (share >= 1) sent_ = wanted;
  return sent_;
}

}  // namespace palpate
