#include "slave/live/operator_port.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "shared/link/thread_priority.h"

namespace palpate {
namespace {

// Larger numbers are rejected, because they come from a faulty client.
constexpr double kAbsurdPosition = 100;  // [m]
constexpr double kAbsurdSpeed = 100;     // [m/s]

bool IsSane(const OperatorCommand& command) {
  return command.p_M.allFinite() && command.velocity.allFinite() &&
         (command.epoch != 0 || !command.engaged) &&
         (!command.R_M_device || command.R_M_device->coeffs().allFinite()) &&
         command.p_M.cwiseAbs().maxCoeff() <= kAbsurdPosition &&
         command.velocity.cwiseAbs().maxCoeff() <= kAbsurdSpeed;
}

constexpr auto kWatchPeriod = std::chrono::milliseconds(2);

// Numbers of a slave that starts later are larger, so that a reset that was requested before its
// start clears no stop.
std::uint64_t FirstStopNumber() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(since_1970).count());
}

constexpr double kMaxForceLimit = 100;     // [N]
constexpr double kMaxYoungModulus = 1e13;  // [Pa]

void Check(const char* name, std::optional<double> value, double high) {
  if (!value || (*value >= kMinSetting && *value <= high)) return;
  throw std::invalid_argument(
      fmt::format("{} = {:g}: expected {:g} to {:g}", name, *value, kMinSetting, high));
}

}  // namespace

OperatorPort::OperatorPort(Manipulator& manipulator, const TeleopTransform& transform,
                           const ManipulatorOptions& limits, double dead_after)
    : manipulator_(manipulator),
      limits_(limits),
      dead_after_(dead_after),
      transform_(transform),
      idle_(limits.source == ManipulatorOptions::Source::kNone ? Phase::kObserving : Phase::kReady),
      guard_(manipulator, limits_) {
  view_.phase = idle_;
  view_.stops = FirstStopNumber();
}

void OperatorPort::BeginOperating() {
  const std::lock_guard lock(mutex_);
  const Phase phase = view_.phase == Phase::kEstop ? Phase::kEstop : Phase::kClutched;
  view_ = {.phase = phase, .stops = view_.stops};
  operating_ = true;
  engaged_ = false;
  needs_new_epoch_ = false;
  state_sequence_ = 0;
  SetPhase(phase);
  begun_.notify_all();
}

void OperatorPort::EndOperating() {
  const std::lock_guard lock(mutex_);
  operating_ = false;
  engaged_ = false;
  SetPhase(idle_);
}

bool OperatorPort::Command(const OperatorCommand& command, Time now) noexcept {
  const std::lock_guard lock(mutex_);
  if (!operating_) return true;
  if (command.sequence <= view_.command_sequence) return true;  // older than one already taken
  if (!IsPermitted(command)) {
    Refuse();
    return false;
  }
  ++counts_.taken;
  if (command.state_sequence > state_sequence_) {
    state_sequence_ = command.state_sequence;
    newer_at_ = now;
  }
  view_.command_sequence = command.sequence;
  view_.echo = command.sent_at;
  view_.taken_at = now;
  if (view_.phase == Phase::kEstop) {
    // This epoch is used: after Reset a newer one is needed to engage.
    view_.epoch = std::max(view_.epoch, command.epoch);
    return true;
  }
  if (!command.engaged) {
    engaged_ = false;
    SetPhase(Phase::kClutched);
    return true;
  }
  if (manipulator_.is_faulty() || is_blind()) {
    // This epoch is used: a newer one is needed to engage.
    view_.epoch = std::max(view_.epoch, command.epoch);
    needs_new_epoch_ = true;
    if (view_.phase != Phase::kHold) HoldUntilEngaged(Event::kHold);
    return true;
  }
  const bool new_epoch = command.epoch > view_.epoch;
  if (guard_.retreats()) return true;
  if (new_epoch || (!engaged_ && view_.phase == Phase::kClutched)) Engage(command);
  if (needs_new_epoch_) return true;
  if (guard_.WayTo(TargetOf(command)) > kLeapTime * limits_.max_speed) {
    Refuse();
    needs_new_epoch_ = true;
    return false;
  }
  if (UnacknowledgedFor(now) <= kAcknowledgementTimeout) Follow(command);
  return true;
}

bool OperatorPort::IsPermitted(const OperatorCommand& command) const noexcept {
  if (!IsSane(command)) return false;
  if (!command.engaged || view_.phase == Phase::kEstop) return true;
  const double speed = transform_.VelocityToSlave(command.velocity).norm();
  return command.epoch >= view_.epoch && speed <= kFastest * limits_.max_speed;
}

void OperatorPort::Refuse() noexcept {
  ++counts_.refused;
  events_.Add(Event::kCommandRefused);
  engaged_ = false;
  SetPhase(Phase::kHold);
}

void OperatorPort::Follow(const OperatorCommand& command) noexcept {
  const auto target = guard_.Permitted(TargetOf(command), &events_);
  if (!target) return HoldUntilEngaged(Event::kLimit);
  engaged_ = true;
  view_.phase = Phase::kFollowing;
  manipulator_.Command(*target);
  Turn(command);
  if (manipulator_.at_limit()) events_.Add(Event::kLimit);
}

void OperatorPort::Engage(const OperatorCommand& command) noexcept {
  view_.epoch = command.epoch;
  needs_new_epoch_ = false;
  transform_.ZeroOffset(command.p_M, manipulator_.Tip() + image_minus_encoders_);
  view_.offset = transform_.offset;
  transform_.begin.reset();
}

// The first command with a rotation is the reference of the engagement, so it does not rotate the
// tool.
void OperatorPort::Turn(const OperatorCommand& command) noexcept {
  if (!command.R_M_device) return;
  if (!transform_.begin) {
    const auto R_S_tool = manipulator_.Rotation();
    if (!R_S_tool) return;
    transform_.begin = {*command.R_M_device, *R_S_tool};
  }
  manipulator_.Turn(transform_.RotationToSlave(*command.R_M_device));
}

void OperatorPort::SetPhase(Phase phase) noexcept {
  if (view_.phase != Phase::kEstop) view_.phase = phase;
  if (view_.phase == Phase::kEstop) {
    guard_.EndRetreat();
    manipulator_.Stop();
  } else if (!guard_.retreats()) {
    manipulator_.Hold();
  }
}

void OperatorPort::HoldUntilEngaged(Event why) noexcept {
  events_.Add(why);
  needs_new_epoch_ = true;
  SetPhase(Phase::kHold);
}

void OperatorPort::Guard(Time now, const ContactState& contact) noexcept {
  const bool follows = view_.phase == Phase::kFollowing;
  if (!guard_.Check(now, contact, follows) || view_.phase == Phase::kEstop) return;
  guard_.BeginRetreat(now, contact);
  if (follows) {
    HoldUntilEngaged(Event::kLimit);
  } else {
    events_.Add(Event::kLimit);
  }
  guard_.ContinueRetreat(now);
}

double OperatorPort::UnacknowledgedFor(Time now) const noexcept {
  return state_sequence_ == 0 ? 0 : SecondsBetween(newer_at_, now);
}

void OperatorPort::Watch(Time now, const ContactState& contact) noexcept {
  const std::lock_guard lock(mutex_);
  Guard(now, contact);
  const double passed = watched_at_ == Time{} ? 0 : SecondsBetween(watched_at_, now);
  unknown_for_ = contact.force ? 0 : unknown_for_ + passed;
  watched_at_ = now;
  const double silence = SecondsBetween(view_.taken_at, now);
  const double unacknowledged = UnacknowledgedFor(now);
  const bool follows = view_.phase == Phase::kFollowing;
  if (follows && (silence > dead_after_ || unacknowledged > kAcknowledgementTimeout)) {
    events_.Add(Event::kHold);
    SetPhase(Phase::kHold);
  }
  const bool is_led = follows || view_.phase == Phase::kHold;
  if ((follows && is_blind()) || (is_led && !needs_new_epoch_ && manipulator_.is_faulty())) {
    HoldUntilEngaged(Event::kHold);
  }
  if (view_.phase == Phase::kHold &&
      std::max(silence, unacknowledged) > dead_after_ + kMaxCommandGap) {
    needs_new_epoch_ = true;
  }
}

bool OperatorPort::AwaitOperator(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (IsWatchDueLocked()) return false;
  begun_.wait(lock, stop, [this] { return IsWatchDueLocked(); });
  return true;
}

bool OperatorPort::IsWatchDue() const {
  const std::lock_guard lock(mutex_);
  return IsWatchDueLocked();
}

void OperatorPort::BeginWatch() noexcept {
  const std::lock_guard lock(mutex_);
  watched_at_ = {};
}

void OperatorPort::EmergencyStop() noexcept {
  const std::lock_guard lock(mutex_);
  engaged_ = false;
  ++view_.stops;
  SetPhase(Phase::kEstop);
}

std::uint64_t OperatorPort::stops() const {
  const std::lock_guard lock(mutex_);
  return view_.stops;
}

bool OperatorPort::Reset(std::uint64_t stops) noexcept {
  const std::lock_guard lock(mutex_);
  if (stops != view_.stops) return false;
  if (view_.phase != Phase::kEstop) return true;
  view_.phase = operating_ ? Phase::kHold : idle_;
  needs_new_epoch_ = true;
  manipulator_.Hold();
  return true;
}

void OperatorPort::SetScales(std::optional<double> position_scale,
                             std::optional<double> force_scale) {
  const std::lock_guard lock(mutex_);
  if (view_.phase == Phase::kFollowing) {
    throw std::logic_error(
        "a scale can change only while the operator is disengaged: open the clutch first");
  }
  // In the old epoch the change would move the tool.
  if (view_.phase == Phase::kHold) needs_new_epoch_ = true;
  if (position_scale) transform_.position_scale = *position_scale;
  if (force_scale) transform_.force_scale = *force_scale;
}

void OperatorPort::SetRegistration(const Eigen::Vector3d& image_minus_encoders) noexcept {
  const std::lock_guard lock(mutex_);
  // A change of the registration while following would move the tool.
  if (view_.phase != Phase::kFollowing) image_minus_encoders_ = image_minus_encoders;
}

OperatorView OperatorPort::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

TeleopTransform OperatorPort::transform() const {
  const std::lock_guard lock(mutex_);
  return transform_;
}

CommandCounts OperatorPort::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

Events OperatorPort::TakeEvents() noexcept {
  const std::lock_guard lock(mutex_);
  const Events events = events_;
  events_.Clear();
  return events;
}

void CommandWatchdog::Start() {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    MakeThreadRealtime(kLinkPriority);
    while (!stop.stop_requested()) {
      rests_ = port_.AwaitOperator(stop) || rests_;
      Look();
      std::this_thread::sleep_for(kWatchPeriod);
    }
  });
}

void CommandWatchdog::Look() {
  const bool rested = std::exchange(rests_, !port_.IsWatchDue());
  if (rests_) return;
  if (rested) port_.BeginWatch();
  port_.Watch(Clock::now(), contact_());
}

void RefuseUnlessFree(const OperatorPort& port, bool touches) {
  if (port.view().phase == Phase::kFollowing) {
    throw std::logic_error(
        "settings can change only while the operator is disengaged: open the clutch first");
  }
  if (touches)
    throw std::logic_error(
        "settings can change only while the tool is free: end the contact first");
}

void CheckRanges(const ParameterChange& change) {
  Check("position_scale", change.position_scale, kMaxPositionScale);
  Check("force_scale", change.force_scale, kMaxForceScale);
  Check("force_limit", change.force_limit, kMaxForceLimit);
  Check("young_modulus", change.young_modulus, kMaxYoungModulus);
}

}  // namespace palpate
