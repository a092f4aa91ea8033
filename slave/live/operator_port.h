// The operator's side of the slave: commands -> T^p -> manipulator, with clutch epochs, watchdog
// and emergency stop.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include <Eigen/Core>

#include "shared/geometry/teleop_transform.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/dead_after.h"
#include "shared/state/slave_state.h"
#include "slave/live/contact_guard.h"
#include "slave/live/slave.h"
#include "slave/manipulator/manipulator.h"

namespace palpate {

// After a gap up to this length, beyond the silence after which the tool holds, motion resumes when
// commands arrive; after a longer one the operator must engage again.
inline constexpr double kMaxCommandGap = 0.220;  // [s]
// An operator whose commands report no newer state for this time gets no force: the tool holds.
inline constexpr double kAcknowledgementTimeout = 0.100;  // [s]
// A command may lead by the distance that the manipulator travels at full speed in this time [s].
inline constexpr double kLeapTime = 0.2;
// Largest accepted speed of a command, relative to the manipulator's.
inline constexpr double kFastest = 2;

struct CommandCounts {
  std::uint64_t taken = 0, refused = 0;
};

// Thread-safe; every call is short. The manipulator must outlive the port.
//
// Two frames meet here. The cameras define S; the manipulator's encoders may disagree by a
// constant, the registration offset `image_minus_encoders`, which the pipeline measures while the
// tool is at rest. Targets are given in S.
//
// For every command the port limits the lead of the target to the distance that the arm travels in
// kLeapTime. It holds the tool while the force has been unknown for `blind_after` or the arm has a
// fault, and lets it go no deeper beyond the guards (ContactGuard). The rotation follows relative
// to the engagement.
class OperatorPort {
 public:
  // `dead_after`: silence of the operator after which the tool holds [s].
  OperatorPort(Manipulator& manipulator, const TeleopTransform& transform,
               const ManipulatorOptions& limits, double dead_after = kUsualDeadAfter);

  void BeginOperating();
  void EndOperating();
  // See Slave::Command.
  bool Command(const OperatorCommand& command, Time now) noexcept;
  // Call at least every few milliseconds: holds the tool when commands have stopped.
  void Watch(Time now, const ContactState& contact) noexcept;
  void EmergencyStop() noexcept;
  // Number of the newest emergency stop: rises with each.
  [[nodiscard]] std::uint64_t stops() const;
  // Ends the emergency stop number `stops`. False: another one arrived, which remains.
  bool Reset(std::uint64_t stops) noexcept;
  // Whether to call Watch: there is an operator, the tool retreats, or the last motion is not
  // accounted for.
  [[nodiscard]] bool IsWatchDue() const;
  // Waits until IsWatchDue. Returns false if it did not have to wait.
  bool AwaitOperator(const std::stop_token& stop);
  // Call it before the first Watch after a time in which IsWatchDue was false.
  void BeginWatch() noexcept;

  // Throws std::logic_error while an operator is engaged.
  void SetScales(std::optional<double> position_scale, std::optional<double> force_scale);
  void SetRegistration(const Eigen::Vector3d& image_minus_encoders) noexcept;

  [[nodiscard]] OperatorView view() const;
  [[nodiscard]] TeleopTransform transform() const;
  [[nodiscard]] CommandCounts counts() const;
  Events TakeEvents() noexcept;

 private:
  // Whether the command is acceptable.
  [[nodiscard]] bool IsPermitted(const OperatorCommand& command) const noexcept;
  [[nodiscard]] Eigen::Vector3d TargetOf(const OperatorCommand& command) const noexcept {
    return transform_.ToSlave(command.p_M) - image_minus_encoders_;
  }
  void Refuse() noexcept;
  void Follow(const OperatorCommand& command) noexcept;
  void Engage(const OperatorCommand& command) noexcept;
  void Turn(const OperatorCommand& command) noexcept;
  void SetPhase(Phase phase) noexcept;
  void HoldUntilEngaged(Event why) noexcept;
  // The force was unknown for longer than the tool may move without it: no epoch is accepted.
  [[nodiscard]] bool is_blind() const { return unknown_for_ > limits_.blind_after; }
  void Guard(Time now, const ContactState& contact) noexcept;
  // Time since the operator reported a newer state [s]. Not checked for clients that report none,
  // such as scripts.
  [[nodiscard]] double UnacknowledgedFor(Time now) const noexcept;

  Manipulator& manipulator_;
  const ManipulatorOptions limits_;
  const double dead_after_;
  [[nodiscard]] bool IsWatchDueLocked() const {
    return operating_ || guard_.retreats() || guard_.is_unseen();
  }

  mutable PriorityInheritanceMutex mutex_;  // guards everything below
  PriorityInheritanceCondition begun_;
  TeleopTransform transform_;
  Eigen::Vector3d image_minus_encoders_ = Eigen::Vector3d::Zero();
  const Phase idle_;  // without an operator
  OperatorView view_;
  bool operating_ = false;
  bool engaged_ = false;  // the clutch is closed in the newest command
  bool needs_new_epoch_ = false;
  ContactGuard guard_;
  // Time with an unknown force while an operator is engaged; a reconnection does not reset it [s].
  double unknown_for_ = 0;
  Time watched_at_{};
  std::uint64_t state_sequence_ = 0;  // of the newest state that the operator reports
  Time newer_at_{};                   // time of its first report
  CommandCounts counts_;
  Events events_;
};

// Watchdog of the operator port, every few milliseconds: holds the tool when commands stop.
class CommandWatchdog {
 public:
  // `contact` is thread-safe. Both must outlive the watch, which ends with this object.
  CommandWatchdog(OperatorPort& port, std::function<ContactState()> contact)
      : port_(port), contact_(std::move(contact)) {}

  // Starts the watchdog thread.
  void Start();
  // Calls Watch of the port if it is due.
  void Look();

 private:
  OperatorPort& port_;
  const std::function<ContactState()> contact_;
  bool rests_ = true;  // IsWatchDue was false at the last call
  std::jthread thread_;
};

// Throws std::logic_error if an operator is engaged or the object is in contact, because settings
// must not change then.
void RefuseUnlessFree(const OperatorPort& port, bool touches);
// Throws std::invalid_argument naming the value out of range, and the range.
void CheckRanges(const ParameterChange& change);

// Constant offset between cameras and encoders (camera mounting, tool length). Measured whenever
// the tool is stationary, so that operator, local model and images share one frame S.
class TipRegistration {
 public:
  // `still`: smallest motion between two images that counts as motion [m], > 0.
  explicit TipRegistration(double still) : still_(still) {}

  // The tip in one image, measured and from the encoders at its time, S [m].
  void Add(const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_encoders) noexcept {
    if (last_encoders_ && (p_S_encoders - *last_encoders_).norm() < still_) {
      // A running mean at first, then a slow average: one noisy image must not move the tool.
      count_ = count_ < kAverage ? count_ + 1 : kAverage;
      offset_ += (p_S_seen - p_S_encoders - offset_) / count_;
    }
    last_encoders_ = p_S_encoders;
  }
  // Cameras minus encoders, S [m]; zero until the tool was stationary for two images.
  [[nodiscard]] const Eigen::Vector3d& offset() const { return offset_; }

 private:
  static constexpr double kAverage = 32;  // [images]
  double still_;
  double count_ = 0;
  std::optional<Eigen::Vector3d> last_encoders_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
};

}  // namespace palpate
