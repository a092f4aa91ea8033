// States and commands as plain values. `shared/wire` converts them to and from messages. The field
// comments of proto/palpate/v1/state.proto apply here too.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/check_details.h"
#include "shared/state/clock.h"
#include "shared/state/verdict.h"

namespace palpate {

// The local contact that the master renders between two states (Adachi et al. 1995): one-sided,
// linear, f = force + stiffness (reference - p) while p lies beyond the plane,
// else 0. Frame S throughout. `force` is that of the object on the tool.
struct LocalModel {
  Eigen::Vector3d reference = Eigen::Vector3d::Zero();  // surface point at rest [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();    // outward unit normal [-]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();      // at the reference [N]
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  // K [N/m]
  double valid_radius = 0;                              // range of |p - reference| [m]
  std::uint32_t revision = 0;  // rises when the master should blend; 0: no model
  bool in_contact = false;     // for the slave; the master decides by itself

  [[nodiscard]] bool known() const { return revision != 0; }
  // Returns the depth of `p_S` below the plane [m]; negative outside.
  [[nodiscard]] double Penetration(const Eigen::Vector3d& p_S) const {
    return normal.dot(reference - p_S);
  }
};

enum class Event : std::uint8_t {
  kContact = 1,
  kRelease,
  kPuncture,
  kTrackingLost,
  kTrackingRegained,
  kLimit,
  kHold,
  kModelChanged = 9,
  kCommandRefused,
};

// A set of events; small enough to copy everywhere.
class Events {
 public:
  void Add(Event e) { bits_ |= Bit(e); }
  void Add(Events other) { bits_ |= other.bits_; }
  [[nodiscard]] bool Has(Event e) const { return (bits_ & Bit(e)) != 0; }
  [[nodiscard]] bool empty() const { return bits_ == 0; }
  void Clear() { bits_ = 0; }

 private:
  static std::uint32_t Bit(Event e) { return 1U << static_cast<unsigned>(e); }
  std::uint32_t bits_ = 0;
};

enum class Phase : std::uint8_t {
  kReady = 1,
  kFollowing,
  kClutched,
  kHold,
  kEstop,
  kObserving,
  kSetup
};

inline constexpr int kMaxFingers = 5;

// FingerState is the state of one of several fingertips.
struct FingerState {
  Eigen::Vector3f p_S_contact = Eigen::Vector3f::Zero();  // [m]; the fingertip's while it is free
  std::optional<Eigen::Vector3f> force;  // object on fingertip, S [N]; nullopt: unknown
  bool in_contact = false;
  Validity validity = Validity::kFailed;
};

// Returns whether a force is present and valid as a number.
template <class Estimate>
bool IsForceKnown(const Estimate& estimate) {
  return estimate.force.has_value() && IsForceKnown(estimate.validity);
}

// The estimate of one image or tactile sample, with the result of its checks. Frame S.
struct ContactEstimate : Verdict {
  std::uint64_t sample = 0;                           // its number at the source
  Time sensed_at{};                                   // slave's clock
  Eigen::Vector3d p_S_tip = Eigen::Vector3d::Zero();  // [m]; the last one while tracking is lost
  Eigen::Vector3d p_S_contact =
      Eigen::Vector3d::Zero();           // contact point, or the nearest point, at rest [m]
  double depth = 0;                      // indentation along the normal [m]; 0: no contact
  std::optional<Eigen::Vector3d> force;  // object on tool [N]; nullopt: unknown
  // Standard deviation of the force's magnitude, or with fingertips of its vector [N].
  double sigma = 0;
  LocalModel local_model;  // revision 0: none
  Events events;
  // Fingertips of scenes with more than one, in the scene's order; the first is the tool.
  std::array<FingerState, kMaxFingers> fingers;
  int finger_count = 0;
  CheckDetails details;  // values of the checks of the tool's sensor
  Time processed_at{};   // end of vision or tactile processing; not sent with a state
  // Moment about the tip of the object's traction on the tool, S [N m]; nullopt: unknown.
  std::optional<Eigen::Vector3d> moment;
  double moment_sigma = 0;  // one standard deviation of the moment's vector [N m]
};

// Part of a state that concerns the operator.
struct OperatorView {
  Phase phase = Phase::kReady;
  std::uint32_t epoch = 0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // of T^p, S [m]
  std::uint64_t command_sequence = 0;
  std::optional<Time> echo;             // master's clock
  Time taken_at{};                      // arrival of that command, slave's clock
  std::uint32_t settings_revision = 0;  // of the active scene and parameters; 0: unknown
  std::uint64_t stops = 0;              // number of the newest emergency stop; 0: unknown
};

// `events`: of all samples and commands since the previous state.
struct SlaveState : ContactEstimate, OperatorView {
  std::uint64_t sequence = 0;
  Time sent_at{};                             // slave's clock
  double echo_delay = 0;                      // [s]
  std::optional<Eigen::Vector3d> true_force;  // object on tool, S [N], at sent_at
};

struct OperatorCommand {
  std::uint64_t sequence = 0;
  Time sent_at{};  // master's clock
  std::uint32_t epoch = 0;
  Eigen::Vector3d p_M = Eigen::Vector3d::Zero();       // [m], absolute in the epoch
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // M [m/s]
  bool engaged = false;
  std::uint64_t state_sequence = 0;
  std::optional<Time> echo;             // slave's clock
  std::uint32_t settings_revision = 0;  // used by the master; 0: unknown
  bool stop = false;                    // the operator's emergency stop
  // Rotation of the device's handle in M; nullopt: the device measures none.
  std::optional<Eigen::Quaterniond> R_M_device;
  bool torque = false;  // the operator requests the moment
};

}  // namespace palpate
