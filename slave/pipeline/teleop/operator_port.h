// The operator's side of the slave: commands -> T^p -> manipulator, with clutch epochs, watchdog
// and emergency stop.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>

#include <Eigen/Core>

#include "shared/geometry/teleop_transform.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/dead_after.h"
#include "shared/state/slave_state.h"
#include "slave/manipulator/manipulator.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// A gap that is shorter, beyond the silence after which the tool holds, ends by itself when
// commands come again; after a longer one the operator engages anew.
inline constexpr double kLongestCommandGap = 0.220;  // [s]
// An operator whose commands tell of no newer state for so long feels nothing: the tool holds.
inline constexpr double kUnfeltTimeout = 0.100;  // [s]
// What the arm goes at its full speed in this time is as far as a command may lead [s].
inline constexpr double kLeapTime = 0.2;
// A hand that moves so many times faster than the arm can is none.
inline constexpr double kFastest = 2;

// What the tool feels at this moment, as far as it is known. Frame S.
struct ContactState {
  std::optional<Eigen::Vector3d> force;  // of the object on the tool [N]; nullopt: unknown
  double depth = 0;                      // of the tool in the object [m]
  Eigen::Vector3d outward{0, 0, 0};      // of the surface touched [-]
  // Where the arm has come since that was sensed, by the local model: size of the force [N], depth
  // [m]; 0: unknown.
  double force_by_now = 0, depth_by_now = 0;
};

// Thread-safe; every call is short. The manipulator must outlive the port.
//
// Two frames meet here. The eyes define S; the manipulator's encoders may disagree by a constant,
// the registration offset `eyes_minus_encoders`, which the pipeline measures while the tool stands.
// Targets are given in S.
//
// Whatever the operator says, the tool goes no farther than the arm goes in kLeapTime, stands while
// the force has been unknown for `blind_after` or the arm has a fault, and goes no deeper beyond
// the guards. Where these retract, it goes back to the surface, also if they were seen to be
// reached only after it was let go; the arm's fault delays that, and where the arm does not come
// it ends.
class OperatorPort {
 public:
  // `dead_after`: silence of the operator after which the tool holds [s].
  OperatorPort(Manipulator& manipulator, const TeleopTransform& transform,
               const ManipulatorOptions& limits, double dead_after = kUsualDeadAfter);

  void BeginOperating();
  void EndOperating();
  // See Slave::Command.
  bool Command(const OperatorCommand& command, Time now) noexcept;
  // Call at least every few milliseconds: holds the tool when commands have stopped, and counts
  // energy.
  void Watch(Time now, const ContactState& contact) noexcept;
  void EmergencyStop() noexcept;
  void Reset() noexcept;
  // Waits while nobody operates, no tool retreats, and what the last motion did was seen: there is
  // nothing to watch.
  void AwaitOperator(const std::stop_token& stop);

  // Throws std::logic_error while somebody follows.
  void SetScales(std::optional<double> position_scale, std::optional<double> force_scale);
  void SetRegistration(const Eigen::Vector3d& eyes_minus_encoders) noexcept;

  [[nodiscard]] OperatorView view() const;
  [[nodiscard]] TeleopTransform transform() const;
  [[nodiscard]] std::uint64_t taken() const;
  [[nodiscard]] std::uint64_t refused() const;
  Events TakeEvents() noexcept;

 private:
  // Whether the operator may say so at all.
  [[nodiscard]] bool IsPermitted(const OperatorCommand& command) const noexcept;
  // How far `p_S`, as the encoders have it, or the next place in the workspace, is from the tip
  // [m].
  [[nodiscard]] double WayTo(const Eigen::Vector3d& p_S) const noexcept;
  [[nodiscard]] Eigen::Vector3d TargetOf(const OperatorCommand& command) const noexcept {
    return transform_.ToSlave(command.p_M) - eyes_minus_encoders_;
  }
  void Refuse() noexcept;
  void Follow(const OperatorCommand& command) noexcept;
  void Engage(const OperatorCommand& command) noexcept;
  void Stand(Phase phase) noexcept;
  void HoldUntilEngaged(Event why) noexcept;
  // Longer than the tool may move without its force being known: no epoch makes it.
  [[nodiscard]] bool is_blind() const { return unknown_for_ > limits_.blind_after; }
  void CountEnergy(const ContactState& contact) noexcept;
  void Guard(Time now, const ContactState& contact) noexcept;
  void Retreat(Time now, const ContactState& contact) noexcept;
  void ContinueRetreat(Time now) noexcept;
  // How long the operator has told of no newer state [s]. Who tells of none, as scripts may, is not
  // judged.
  [[nodiscard]] double UnfeltFor(Time now) const noexcept;

  Manipulator& manipulator_;
  const ManipulatorOptions limits_;
  const double dead_after_;
  mutable PriorityInheritanceMutex mutex_;  // guards everything below
  std::condition_variable_any begun_;
  TeleopTransform transform_;
  Eigen::Vector3d eyes_minus_encoders_ = Eigen::Vector3d::Zero();
  OperatorView view_;
  Eigen::Vector3d last_tip_ = Eigen::Vector3d::Zero();  // encoders, S [m]
  bool operating_ = false;
  bool engaged_ = false;  // the clutch is closed in the newest command
  bool needs_new_epoch_ = false;
  std::optional<Eigen::Vector3d>
      outward_;  // no deeper than now, seen against it: a guard is reached
  std::optional<Eigen::Vector3d> retreat_;  // where the tool retracts to, encoders, S [m]
  std::uint32_t retreat_frame_ = 0;         // the arm's, of that place
  Time retreat_until_{};
  Time followed_at_{};   // last
  bool unseen_ = false;  // what that did, by the guards
  // The force, while somebody operated: who comes again is not given as long again [s].
  double unknown_for_ = 0;
  Time watched_at_{};
  std::uint64_t state_sequence_ = 0;  // of the newest state that the operator tells of
  Time newer_at_{};                   // when that one was told first
  std::uint64_t taken_ = 0, refused_ = 0;
  Events events_;
};

// Looks after the operator's port every few milliseconds: the watchdog that holds the tool when
// commands stop, and the energies.
class CommandWatchdog {
 public:
  // `contact` is thread-safe. Both must outlive the watch, which ends with this object.
  CommandWatchdog(OperatorPort& port, std::function<ContactState()> contact);

 private:
  std::jthread thread_;
};

// Throws std::logic_error: somebody follows or the object is touched, so that nothing may change
// under the hand.
void RefuseUnlessFree(const OperatorPort& port, bool touches);
// Throws std::invalid_argument naming what is out of its range, and the range.
void CheckRanges(const ParameterChange& change);

// The eyes and the manipulator's encoders disagree by a constant (camera mounting, tool length).
// Measured whenever the tool stands, so that the operator, the local model and the pictures share
// one frame S.
class TipRegistration {
 public:
  // `still`: smallest motion between two pictures that counts as motion [m], > 0.
  explicit TipRegistration(double still) : still_(still) {}

  // One picture's tip, as seen and as the encoders said when it was taken, S [m].
  void Add(const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_encoders) noexcept {
    if (last_encoders_ && (p_S_encoders - *last_encoders_).norm() < still_) {
      // A running mean at first, then a slow average: one noisy picture must not move the tool.
      count_ = count_ < kAverage ? count_ + 1 : kAverage;
      offset_ += (p_S_seen - p_S_encoders - offset_) / count_;
    }
    last_encoders_ = p_S_encoders;
  }
  // Eyes minus encoders, S [m]; zero until the tool has stood for two pictures.
  [[nodiscard]] const Eigen::Vector3d& offset() const { return offset_; }

 private:
  static constexpr double kAverage = 32;  // [pictures]
  double still_;
  double count_ = 0;
  std::optional<Eigen::Vector3d> last_encoders_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
};

}  // namespace palpate
