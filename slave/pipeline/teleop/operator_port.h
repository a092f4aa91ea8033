// The operator's side of the slave: commands -> T^p -> manipulator, with clutch epochs, watchdog
// and emergency stop.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include <Eigen/Core>

#include "shared/geometry/teleop_transform.h"
#include "shared/state/slave_state.h"
#include "slave/manipulator/manipulator.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Silence after which the tool holds its place (contracts, wire).
inline constexpr double kCommandTimeout = 0.030;  // [s]
// A gap shorter than this ends by itself when commands come again; after a longer one the operator
// engages anew.
inline constexpr double kResumeWithin = 0.250;  // [s]

// Thread-safe; every call is short. The manipulator must outlive the port.
//
// Two frames meet here. The eyes define S; the manipulator's encoders may disagree by a constant,
// the registration offset `eyes_minus_encoders`, which the pipeline measures while the tool stands.
// Targets are given in S.
class OperatorPort {
 public:
  OperatorPort(Manipulator& manipulator, const TeleopTransform& transform);

  void BeginOperating();
  void EndOperating();
  // See Slave::Command.
  bool Command(const OperatorCommand& command, Time now) noexcept;
  // Call at least every few milliseconds: holds the tool when commands have stopped, and counts
  // energy with `force_S`, the force of the object on the tool [N].
  void Watch(Time now, const Eigen::Vector3d& force_S) noexcept;
  void EmergencyStop() noexcept;
  void Reset() noexcept;

  // Throws std::logic_error while somebody follows.
  void SetScales(std::optional<double> position_scale, std::optional<double> force_scale);
  void SetRegistration(const Eigen::Vector3d& eyes_minus_encoders) noexcept;

  [[nodiscard]] OperatorView view() const;
  [[nodiscard]] TeleopTransform transform() const;
  [[nodiscard]] std::uint64_t taken() const;
  [[nodiscard]] std::uint64_t refused() const;
  Events TakeEvents() noexcept;

 private:
  void Engage(const OperatorCommand& command) noexcept;
  void Stand(Phase phase) noexcept;

  Manipulator& manipulator_;
  mutable std::mutex mutex_;  // guards everything below
  TeleopTransform transform_;
  Eigen::Vector3d eyes_minus_encoders_ = Eigen::Vector3d::Zero();
  OperatorView view_;
  Eigen::Vector3d last_tip_ = Eigen::Vector3d::Zero();  // encoders, S [m]
  bool operating_ = false;
  bool engaged_ = false;  // the clutch is closed in the newest command
  bool needs_new_epoch_ = false;
  std::uint64_t taken_ = 0, refused_ = 0;
  Events events_;
};

// Looks after the operator's port every few milliseconds: the watchdog that holds the tool when
// commands stop, and the energies.
class CommandWatchdog {
 public:
  // `force` tells the force of the object on the tool, frame S [N]; thread-safe. Both must outlive
  // the watch, which ends with this object.
  CommandWatchdog(OperatorPort& port, std::function<Eigen::Vector3d()> force);

 private:
  std::jthread thread_;
};

// Throws std::logic_error: somebody follows, so a model must not change under the hand.
void RefuseWhileFollowing(const OperatorPort& port);
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
