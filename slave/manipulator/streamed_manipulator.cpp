#include "slave/manipulator/streamed_manipulator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace palpate {
namespace {

constexpr double kMaxStep = 0.05;  // limits the leap after a pause of the slave [s]
constexpr double kFastest = 3;     // largest accepted speed between reports, relative to max_speed
// Tolerance of a report: the distance at max_speed in this time [s].
constexpr double kSlack = 0.01;
constexpr double kOutside = 0.02;  // of the workspace's diagonal: how far a tip may overshoot it
constexpr double kSmoothing = 0.05;
constexpr double kSettles = 0.05;  // time after the last error at which a fault ends [s]
constexpr const char* kNobody = "no driver of the manipulator is connected (DriveTool)";

double Outside(const ManipulatorOptions& options, const Eigen::Vector3d& p_S) {
  const Eigen::Vector3d within =
      p_S.cwiseMax(options.workspace_min).cwiseMin(options.workspace_max);
  return (p_S - within).norm();
}

}  // namespace

StreamedManipulator::StreamedManipulator(const ManipulatorOptions& options, Now now)
    : options_(options),
      now_(now),
      follower_(options),
      rotation_(options.max_angular_speed),
      fault_(kNobody) {}

bool StreamedManipulator::Command(const Eigen::Vector3d& p_S_target) noexcept {
  const std::lock_guard lock(mutex_);
  if (!reading_ || HasFault(now_()) || !p_S_target.allFinite()) return false;
  // Somebody may have moved the arm while it was stopped.
  if (motion_ != ArmAim::Motion::kFollow) follower_.Place(reading_->p_S_tip);
  motion_ = ArmAim::Motion::kFollow;
  return follower_.Aim(p_S_target);
}

void StreamedManipulator::Turn(const Eigen::Quaterniond& R_S_target) noexcept {
  const std::lock_guard lock(mutex_);
  if (motion_ != ArmAim::Motion::kFollow || !reading_ || !reading_->R_S_tool) return;
  rotation_.Follow(R_S_target, *reading_->R_S_tool);
}

std::optional<Eigen::Quaterniond> StreamedManipulator::Rotation() const noexcept {
  const std::lock_guard lock(mutex_);
  return reading_ ? reading_->R_S_tool : std::nullopt;
}

void StreamedManipulator::Hold() noexcept {
  const std::lock_guard lock(mutex_);
  HoldPosition();
  motion_ = ArmAim::Motion::kHold;
}

void StreamedManipulator::Stop() noexcept {
  const std::lock_guard lock(mutex_);
  HoldPosition();
  motion_ = ArmAim::Motion::kStop;
}

// Sets the target once. An arm that yields under load would creep if its present position became
// the target repeatedly.
void StreamedManipulator::HoldPosition() noexcept {
  if (motion_ != ArmAim::Motion::kFollow) return;
  motion_ = ArmAim::Motion::kHold;
  if (!reading_) return;
  follower_.Place(reading_->p_S_tip);
  rotation_.Hold(reading_->R_S_tool);
}

Eigen::Vector3d StreamedManipulator::Tip() const noexcept {
  const std::lock_guard lock(mutex_);
  return reading_ ? reading_->p_S_tip : options_.home;
}

Eigen::Vector3d StreamedManipulator::TipAt(Time t) const noexcept {
  const std::lock_guard lock(mutex_);
  if (!reading_) return options_.home;
  const std::size_t oldest = count_ > kMaxKept ? count_ - kMaxKept : 0;
  std::size_t k = count_;
  while (k > oldest && kept_[(k - 1) % kMaxKept].at > t) --k;
  if (k == count_) return reading_->p_S_tip;
  const Kept& after = kept_[k % kMaxKept];
  if (k == oldest) return after.p_S_tip;
  const Kept& before = kept_[(k - 1) % kMaxKept];
  const double share = SecondsBetween(before.at, t) / SecondsBetween(before.at, after.at);
  return before.p_S_tip + share * (after.p_S_tip - before.p_S_tip);
}

std::uint32_t StreamedManipulator::frame() const noexcept {
  const std::lock_guard lock(mutex_);
  return driver_.frame;
}

bool StreamedManipulator::at_limit() const noexcept {
  const std::lock_guard lock(mutex_);
  return follower_.at_limit() || rotation_.at_limit() || (reading_ && reading_->at_limit);
}

bool StreamedManipulator::IsSilent(Time now) const noexcept {
  return driver_.id != 0 && SecondsBetween(driver_.received_at, now) > options_.silence;
}

std::string StreamedManipulator::SilenceInWords(Time now) const {
  return fmt::format("the manipulator's driver has been silent for {:.3f} s",
                     SecondsBetween(driver_.received_at, now));
}

bool StreamedManipulator::IsFaultyAt(Time now) const noexcept {
  const std::lock_guard lock(mutex_);
  return HasFault(now);
}

std::optional<ArmHealth> StreamedManipulator::health() const {
  const Time now = now_();
  const std::lock_guard lock(mutex_);
  ArmHealth health{.driver = driver_.name, .fault = fault_, .reports = driver_.reports};
  if (IsSilent(now)) health.fault = SilenceInWords(now);
  if (period_ > 0 && !IsSilent(now) && driver_.id != 0) health.rate = 1 / period_;
  if (const auto found = fit_.found()) {
    health.lag = found->lag;
    health.scale = found->scale;
  }
  return health;
}

std::optional<Eigen::Vector3d> StreamedManipulator::measured_force() const noexcept {
  const Time now = now_();
  const std::lock_guard lock(mutex_);
  if (!reading_ || HasFault(now)) return std::nullopt;
  return reading_->force;
}

std::optional<DriverRefusal> StreamedManipulator::Rejects(DriverId driver,
                                                          const ArmReading& reading,
                                                          Time arrived_at) const {
  if (driver_.id == 0) return std::nullopt;
  if (driver != driver_.id) {
    if (IsSilent(arrived_at)) return std::nullopt;
    return {{fmt::format("the manipulator is driven by {}: expected one driver at a time",
                         driver_.name.empty() ? "another stream" : driver_.name),
             true}};
  }
  if (reading.sequence <= driver_.sequence) {
    return DriverRefusal{fmt::format("sequence = {}: expected one above the last, {}",
                                     reading.sequence, driver_.sequence)};
  }
  if (reading.measured_at <= driver_.measured_at) {
    return DriverRefusal{
        fmt::format("measured_at: expected a time that increases; this one changed by {} s",
                    SecondsBetween(driver_.measured_at, reading.measured_at))};
  }
  return std::nullopt;
}

std::string StreamedManipulator::FindFault(const ArmReading& reading, Time measured_at) const {
  if (!reading.fault.empty()) return "the manipulator's driver reports: " + reading.fault;
  const double reserve = kOutside * (options_.workspace_max - options_.workspace_min).norm();
  const double outside = Outside(options_, reading.p_S_tip);
  if (outside > reserve) {
    return fmt::format("the manipulator reports a tip {:.3g} mm outside its workspace",
                       1e3 * outside);
  }
  if (!reading_) return {};
  const double dt = SecondsBetween(kept_[(count_ - 1) % kMaxKept].at, measured_at);
  const double way = (reading.p_S_tip - reading_->p_S_tip).norm();
  if (way <= options_.max_speed * (kFastest * dt + kSlack)) return {};
  return fmt::format(
      "the manipulator reports a tip {:.3g} mm from the one {:.3g} ms earlier: its largest speed "
      "is {:.3g} mm/s",
      1e3 * way, 1e3 * dt, 1e3 * options_.max_speed);
}

void StreamedManipulator::BeginWith(DriverId driver, const std::string& name) {
  driver_.id = driver;
  driver_.name = name;
  ++driver_.frame;
  driver_.clock.Reset();
  reading_.reset();
  count_ = 0;
  period_ = 0;
  fit_ = {};
}

void StreamedManipulator::Keep(const ArmReading& reading, Time measured_at) noexcept {
  const Kept* last = count_ > 0 ? &kept_[(count_ - 1) % kMaxKept] : nullptr;
  // Times must rise, even if a new fastest report changes the clock offset.
  const Time at = last ? std::max(measured_at, last->at + Clock::duration(1)) : measured_at;
  const double dt = last ? SecondsBetween(last->at, at) : 0;
  if (motion_ == ArmAim::Motion::kFollow) {
    fit_.Add(reading.p_S_tip, follower_.tip(), follower_.velocity(), dt);
  }
  kept_[count_++ % kMaxKept] = {at, reading.p_S_tip};
  period_ = count_ == 2 ? dt : period_ + kSmoothing * (dt - period_);
  if (!reading_) {
    rotation_.Begin(reading.R_S_tool);
    follower_.Place(reading.p_S_tip);
  }
  reading_ = reading;
}

void StreamedManipulator::Fail(const std::string& why, Time now) {
  fault_ = why;
  wrong_at_ = now;
  HoldPosition();
}

std::optional<DriverRefusal> StreamedManipulator::Take(DriverId driver, const std::string& name,
                                                       const ArmReading& reading, Time arrived_at) {
  const std::lock_guard lock(mutex_);
  if (auto refusal = Rejects(driver, reading, arrived_at)) return refusal;
  // Reports even a short silence.
  if (IsSilent(arrived_at)) Fail(SilenceInWords(arrived_at), arrived_at);
  if (driver != driver_.id) BeginWith(driver, name);
  driver_.sequence = reading.sequence;
  driver_.measured_at = reading.measured_at;
  driver_.received_at = arrived_at;
  ++driver_.reports;
  const Time measured_at = driver_.clock.Map(reading.measured_at, arrived_at);
  const std::string fault = FindFault(reading, measured_at);
  if (!fault.empty()) {
    Fail(fault, arrived_at);
  } else if (!fault_.empty() && SecondsBetween(wrong_at_, arrived_at) > kSettles) {
    fault_.clear();
    follower_.Place(reading.p_S_tip);  // the arm is held at its present position
  }
  if (!fault.empty() && reading.fault.empty()) return std::nullopt;  // the report is rejected
  Keep(reading, measured_at);
  return std::nullopt;
}

void StreamedManipulator::Leave(DriverId driver) {
  const std::lock_guard lock(mutex_);
  if (driver != driver_.id) return;
  driver_.id = 0;
  driver_.name.clear();
  Fail(kNobody, now_());
}

ArmAim StreamedManipulator::Aim(Time now) {
  const std::lock_guard lock(mutex_);
  const double dt = stepped_at_ ? SecondsBetween(*stepped_at_, now) : 0;
  stepped_at_ = now;
  if (motion_ == ArmAim::Motion::kFollow && HasFault(now)) HoldPosition();
  const double step = std::clamp(dt, 0.0, kMaxStep);
  follower_.Step(step);
  rotation_.Step(step);
  ArmAim aim{.motion = motion_, .sequence = ++aims_, .p_S_tip = follower_.tip()};
  if (motion_ == ArmAim::Motion::kFollow) aim.velocity = follower_.velocity();
  aim.R_S_tool = rotation_.rotation();
  if (reading_) aim.echo = reading_->measured_at;
  return aim;
}

}  // namespace palpate
