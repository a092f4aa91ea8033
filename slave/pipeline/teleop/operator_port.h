// The operator's side of the slave: commands -> T^p -> manipulator, with clutch epochs, watchdog
// and emergency stop.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>

#include <Eigen/Core>

#include "shared/geometry/teleop_transform.h"
#include "shared/state/slave_state.h"
#include "slave/manipulator/manipulator.h"

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

}  // namespace palpate
