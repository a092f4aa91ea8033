// What the slave tells and what the operator's side tells, as plain values. `shared/wire` turns
// them into messages and back; the field comments of proto/palpate/v1/state.proto hold here too.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "shared/state/check_details.h"
#include "shared/state/clock.h"
#include "shared/state/failed_check.h"
#include "shared/state/validity.h"

namespace palpate {

// The contact that the master renders by itself between two states (Adachi et al. 1995):
// one-sided, linear, f = force + stiffness (reference - p) while p lies beyond the plane,
// else 0. Frame S throughout. `force` is that of the object on the tool.
struct LocalModel {
  Eigen::Vector3d reference = Eigen::Vector3d::Zero();  // surface point at rest [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();    // outward unit normal [-]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();      // at the reference [N]
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  // K [N/m]
  double valid_radius = 0;                              // range of |p - reference| [m]
  std::uint32_t revision = 0;  // rises when the master should blend; 0: no model
  bool in_contact = false;     // as the slave sees it; the master decides for itself

  [[nodiscard]] bool known() const { return revision != 0; }
  // How deep `p_S` lies below the plane [m]; negative outside.
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
  kEstop,
  kModelChanged,
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

enum class Phase : std::uint8_t { kReady = 1, kFollowing, kClutched, kHold, kEstop };

inline constexpr int kMaxFingers = 5;

// One of several fingertips.
struct FingerState {
  Eigen::Vector3f p_S_contact = Eigen::Vector3f::Zero();  // [m]; the fingertip's while it is free
  std::optional<Eigen::Vector3f> force;  // object on fingertip, S [N]; nullopt: unknown
  bool in_contact = false;
  Validity validity = Validity::kFailed;
};

// It is there, and a number.
template <class Felt>
bool IsForceKnown(const Felt& felt) {
  return felt.force.has_value() && IsForceKnown(felt.validity);
}

// What one picture or tactile sample told. Frame S.
struct ContactEstimate {
  std::uint64_t sample = 0;                           // its number at the source
  Time sensed_at{};                                   // slave's clock
  Eigen::Vector3d p_S_tip = Eigen::Vector3d::Zero();  // [m]; the last one while tracking is lost
  Eigen::Vector3d p_S_contact =
      Eigen::Vector3d::Zero();           // place touched, or the nearest, at rest [m]
  double depth = 0;                      // indentation along the normal [m]; 0: no contact
  std::optional<Eigen::Vector3d> force;  // object on tool [N]; nullopt: unknown
  // Of the force's magnitude; with fingertips of its vector, whose direction they tell too [N].
  double sigma = 0;
  Validity validity = Validity::kFailed;
  FailedCheck check = FailedCheck::kNone;  // why it is not valid, where a check says so
  LocalModel local_model;                  // revision 0: none
  Events events;
  // Of scenes with more than one fingertip, in the scene's order; the first is the tool.
  std::array<FingerState, kMaxFingers> fingers;
  int finger_count = 0;
  CheckDetails details;  // of the tool, what the checks of its sense measured
  Time processed_at{};   // eyes or fingertips had done with the sample; never travels with a state
  std::optional<Eigen::Vector3d> moment;  // of `force` about the tip, S [N m]; for observers
};

// What the operator's side adds.
struct OperatorView {
  Phase phase = Phase::kReady;
  std::uint32_t epoch = 0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // of T^p, S [m]
  std::uint64_t command_sequence = 0;
  std::optional<Time> echo;              // master's clock
  Time taken_at{};                       // slave's clock, when that command was taken
  double energy_in = 0, energy_out = 0;  // [J]
  std::uint32_t settings_revision = 0;   // of the scene and parameters in force; 0: not told
};

// `events`: of all samples and commands since the state before.
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
  double energy_in = 0, energy_out = 0;  // [J]
  std::uint64_t state_sequence = 0;
  std::optional<Time> echo;             // slave's clock
  std::uint32_t settings_revision = 0;  // that the master goes by; 0: not told
  bool stop = false;                    // the operator's emergency stop
};

}  // namespace palpate
