#include "master/haptics/force_chain.h"

#include <algorithm>
#include <cmath>

#include "master/haptics/tick_message.h"
#include "shared/wire/enum_names.h"

namespace palpate {
namespace {

// No damping at lower speeds, where noise determines the direction [m/s].
constexpr double kSlowest = 1e-4;

}  // namespace

std::string_view ToString(Reason reason) {
  return ProtoNameOf(ToProto(reason));
}

std::string ToString(const Reasons& reasons) {
  std::string text;
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    if (!reasons.Has(static_cast<Reason>(i))) continue;
    if (!text.empty()) text += '+';
    text += ToString(static_cast<Reason>(i));
  }
  return text;
}

std::string InWords(const Reasons& reasons) {
  std::string words;
  for (const char c : ToString(reasons)) {
    if (c == '+') {
      words += ", ";
    } else {
      words += c == '_' ? ' ' : c;
    }
  }
  return words;
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

double PassivityControl::Leak(const Eigen::Vector3d& f_M) const noexcept {
  const double eaten = kPhysicalDamping * last_dp_.squaredNorm() / last_dt_;
  return std::clamp(0.5 * (held_ - f_M).dot(last_dp_), -eaten, eaten);
}

void PassivityControl::Observe(const Eigen::Vector3d& p_M, const Eigen::Vector3d& f_M,
                               double dt) noexcept {
  balance_ += Leak(f_M);
  min_ = std::min(min_, balance_);
  last_dp_ = has_position_ ? Eigen::Vector3d(p_M - last_p_) : Eigen::Vector3d(0, 0, 0);
  const Eigen::Vector3d v = last_dp_ / dt;
  acceleration_ += std::min(1.0, dt / kSmooth) * ((v - last_v_) / dt - acceleration_);
  last_v_ = v;
  last_p_ = p_M;
  last_dt_ = dt;
  held_ = f_M;
  has_position_ = true;
  const double work = -f_M.dot(last_dp_);
  (work > 0 ? energy_in_ : energy_out_) += std::abs(work);
  min_work_ = std::min(min_work_, energy_in_ - energy_out_);
  const bool shown = f_M != Eigen::Vector3d::Zero();
  if (!shown && rendered_force_) stored_ = std::max(0.0, balance_);
  rendered_force_ = shown;
  balance_ += work;
  if (shown) return;
  const double eaten = kPhysicalDamping * last_dp_.squaredNorm() / dt;
  const double at_once = std::clamp(-kEnergyCredit - balance_, 0.0, eaten);
  balance_ = std::min(balance_ + at_once + std::min(eaten, kEnergyCredit / kRepayTime * dt), 0.0);
}

Eigen::Vector3d PassivityControl::Apply(const Eigen::Vector3d& f_M, const Eigen::Vector3d& v_M,
                                        double dt) const noexcept {
  const double speed = v_M.norm(), missing = -(balance_ + Leak(f_M));
  // Motion into the object adds the missing energy by itself.
  if (missing <= kUndamped || speed < kSlowest || !(f_M.dot(v_M) > 0)) return f_M;
  const double alpha = std::min(missing / (dt * speed * speed), max_damping_);
  const double size = std::min(alpha * speed, f_M.norm());
  return f_M - size / speed * v_M;
}

Eigen::Vector3d PassivityControl::WithinBalance(const Eigen::Vector3d& f_M,
                                                const Eigen::Vector3d& v_M,
                                                double slew) const noexcept {
  const double size = f_M.norm();
  if (!(size > 0)) return f_M;
  const double giving_way = std::max(f_M.dot(v_M) / size, 0.0);
  const double faster = std::max(f_M.dot(acceleration_) / size, 0.0);
  const double falls = giving_way / slew + faster * size / (3 * slew * slew);
  const double stiffness = 1 / std::max(1 / kMaxStiffness, falls);
  // Iterates, because a weaker force also leaks less energy.
  Eigen::Vector3d paid = f_M;
  for (int i = 0; i < 2; ++i) {
    const double energy = balance_ + Leak(paid) + kEnergyCredit;
    const double most = std::sqrt(2 * std::max(energy, 0.0) * stiffness);
    if (most < paid.norm()) paid = most / size * f_M;
  }
  return paid;
}

Eigen::Vector3d PassivityControl::LimitToBalance(const Eigen::Vector3d& f_M,
                                                 const Eigen::Vector3d& v_M,
                                                 double slew) const noexcept {
  const Eigen::Vector3d paid = WithinBalance(f_M, v_M, slew),
                        rest = WithinBalance(held_, v_M, slew);
  if (rest == held_) return paid;
  const Eigen::Vector3d along = held_.normalized();
  return std::clamp(paid.dot(along), 0.0, rest.norm()) * along;
}

void OutputBlend::Go(Target target, double duration) noexcept {
  const bool ends_earlier = duration_ - elapsed_ <= duration;
  if (target == Target::kZero && target_ == Target::kZero && ends_earlier) return;
  target_ = target;
  from_ = sent_;
  duration_ = duration;
  elapsed_ = 0;
}

void OutputBlend::Drop() noexcept {
  sent_.setZero();
  Go(Target::kZero, 0);
}

Eigen::Vector3d OutputBlend::Wanted(const Eigen::Vector3d& rendered, double dt) noexcept {
  elapsed_ += dt;
  Eigen::Vector3d wanted(0, 0, 0);
  if (target_ == Target::kRendered) wanted = rendered;
  if (target_ == Target::kFrozen) wanted = from_;
  if (is_blending()) wanted = from_ + elapsed_ / duration_ * (wanted - from_);
  return wanted;
}

Eigen::Vector3d OutputBlend::Send(const Eigen::Vector3d& wanted, double dt) noexcept {
  const Eigen::Vector3d way = wanted - sent_;
  const double most = slew_ * std::min(dt, kTick);
  is_slewed_ = way.norm() > most;
  if (is_slewed_) return sent_ += most / way.norm() * way;
  return sent_ = wanted;
}

}  // namespace palpate
