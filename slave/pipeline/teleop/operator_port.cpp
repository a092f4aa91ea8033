#include "slave/pipeline/teleop/operator_port.h"

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

// Beyond these no hand and no tool ever goes: such numbers come from a broken client.
constexpr double kAbsurdPosition = 100;  // [m]
constexpr double kAbsurdSpeed = 100;     // [m/s]

bool IsSane(const OperatorCommand& command) {
  return command.p_M.allFinite() && command.velocity.allFinite() &&
         (command.epoch != 0 || !command.engaged) &&
         command.p_M.cwiseAbs().maxCoeff() <= kAbsurdPosition &&
         command.velocity.cwiseAbs().maxCoeff() <= kAbsurdSpeed;
}

constexpr auto kWatchPeriod = std::chrono::milliseconds(2);
constexpr double kMaxForceLimit = 100;     // [N]
constexpr double kMaxYoungModulus = 1e13;  // [Pa]

void Check(const char* name, std::optional<double> value, double high) {
  if (!value || (*value > 0 && *value <= high)) return;
  throw std::invalid_argument(
      fmt::format("{} = {:g}: accepted is 0 < {} <= {:g}", name, *value, name, high));
}

}  // namespace

OperatorPort::OperatorPort(Manipulator& manipulator, const TeleopTransform& transform)
    : manipulator_(manipulator), transform_(transform), last_tip_(manipulator.Tip()) {}

void OperatorPort::BeginOperating() {
  const std::lock_guard lock(mutex_);
  const Phase phase = view_.phase == Phase::kEstop ? Phase::kEstop : Phase::kClutched;
  view_ = {};
  view_.phase = phase;
  operating_ = true;
  engaged_ = false;
  needs_new_epoch_ = false;
  manipulator_.Hold();
}

void OperatorPort::EndOperating() {
  const std::lock_guard lock(mutex_);
  operating_ = false;
  engaged_ = false;
  Stand(Phase::kReady);
}

bool OperatorPort::Command(const OperatorCommand& command, Time now) noexcept {
  const std::lock_guard lock(mutex_);
  if (!operating_) return true;
  if (command.sequence <= view_.command_sequence) return true;  // older than one already taken
  const bool goes_back = command.engaged && command.epoch < view_.epoch;
  if (!IsSane(command) || (goes_back && view_.phase != Phase::kEstop)) {
    ++refused_;
    events_.Add(Event::kCommandRefused);
    engaged_ = false;
    Stand(Phase::kHold);
    return false;
  }
  ++taken_;
  view_.command_sequence = command.sequence;
  view_.echo = command.sent_at;
  view_.taken_at = now;
  if (view_.phase == Phase::kEstop) {
    view_.epoch = std::max(view_.epoch, command.epoch);  // used up: after Reset a newer one engages
    return true;
  }
  if (!command.engaged) {
    engaged_ = false;
    Stand(Phase::kClutched);
    return true;
  }
  const bool new_epoch = command.epoch > view_.epoch;
  if (new_epoch || (!engaged_ && view_.phase == Phase::kClutched)) Engage(command);
  if (needs_new_epoch_) return true;
  engaged_ = true;
  view_.phase = Phase::kFollowing;
  manipulator_.Command(transform_.ToSlave(command.p_M) - eyes_minus_encoders_);
  if (manipulator_.at_limit()) events_.Add(Event::kLimit);
  return true;
}

void OperatorPort::Engage(const OperatorCommand& command) noexcept {
  view_.epoch = command.epoch;
  needs_new_epoch_ = false;
  transform_.ZeroOffset(command.p_M, manipulator_.Tip() + eyes_minus_encoders_);
  view_.offset = transform_.offset;
}

void OperatorPort::Stand(Phase phase) noexcept {
  manipulator_.Hold();
  if (view_.phase != Phase::kEstop) view_.phase = phase;
}

void OperatorPort::Watch(Time now, const Eigen::Vector3d& force_S) noexcept {
  const std::lock_guard lock(mutex_);
  const Eigen::Vector3d tip = manipulator_.Tip();
  const double work = -force_S.dot(tip - last_tip_);  // of the tool on the object [J]
  last_tip_ = tip;
  if (operating_) (work > 0 ? view_.energy_in : view_.energy_out) += std::abs(work);

  const double silence = SecondsBetween(view_.taken_at, now);
  if (view_.phase == Phase::kFollowing && silence > kCommandTimeout) {
    events_.Add(Event::kHold);
    Stand(Phase::kHold);
  }
  if (view_.phase == Phase::kHold && silence > kResumeWithin) needs_new_epoch_ = true;
}

void OperatorPort::EmergencyStop() noexcept {
  const std::lock_guard lock(mutex_);
  engaged_ = false;
  Stand(Phase::kEstop);
  events_.Add(Event::kEstop);
}

void OperatorPort::Reset() noexcept {
  const std::lock_guard lock(mutex_);
  if (view_.phase != Phase::kEstop) return;
  view_.phase = operating_ ? Phase::kHold : Phase::kReady;
  needs_new_epoch_ = true;
}

void OperatorPort::SetScales(std::optional<double> position_scale,
                             std::optional<double> force_scale) {
  const std::lock_guard lock(mutex_);
  if (view_.phase == Phase::kFollowing) {
    throw std::logic_error("a scale changes only while nobody follows: open the clutch first");
  }
  // Going on in the old epoch would move the tool by the change.
  if (view_.phase == Phase::kHold) needs_new_epoch_ = true;
  if (position_scale) transform_.position_scale = *position_scale;
  if (force_scale) transform_.force_scale = *force_scale;
}

void OperatorPort::SetRegistration(const Eigen::Vector3d& eyes_minus_encoders) noexcept {
  const std::lock_guard lock(mutex_);
  // Moving the registration while following would move the tool under the operator's hand.
  if (view_.phase != Phase::kFollowing) eyes_minus_encoders_ = eyes_minus_encoders;
}

OperatorView OperatorPort::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

TeleopTransform OperatorPort::transform() const {
  const std::lock_guard lock(mutex_);
  return transform_;
}

std::uint64_t OperatorPort::taken() const {
  const std::lock_guard lock(mutex_);
  return taken_;
}

std::uint64_t OperatorPort::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

Events OperatorPort::TakeEvents() noexcept {
  const std::lock_guard lock(mutex_);
  const Events events = events_;
  events_.Clear();
  return events;
}

CommandWatchdog::CommandWatchdog(OperatorPort& port, std::function<Eigen::Vector3d()> force)
    : thread_([&port, force = std::move(force)](const std::stop_token& stop) {
        MakeThreadRealtime(kLinkPriority);
        while (!stop.stop_requested()) {
          port.Watch(Clock::now(), force());
          std::this_thread::sleep_for(kWatchPeriod);
        }
      }) {}

void RefuseWhileFollowing(const OperatorPort& port) {
  if (port.view().phase == Phase::kFollowing) {
    throw std::logic_error("the model changes only while nobody follows: open the clutch first");
  }
}

void CheckRanges(const ParameterChange& change) {
  Check("position_scale", change.position_scale, kMaxPositionScale);
  Check("force_scale", change.force_scale, kMaxForceScale);
  Check("force_limit", change.force_limit, kMaxForceLimit);
  Check("young_modulus", change.young_modulus, kMaxYoungModulus);
}

}  // namespace palpate
