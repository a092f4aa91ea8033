// What becomes of a force on its way from the slave to the hand, one value per station, and why it
// changed: the view that answers "I enabled feedback but feel nothing".
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace palpate {

// Why a tick's force is not simply the slave's.
enum class Reason : std::uint8_t {
  kNotFollowing,  // the operator does not follow: nothing is shown
  kStale,         // no state for 30 ms
  kUnknown,       // the slave does not know the force
  kOtherEpoch,    // the slave no longer serves this engagement
  kFading,        // towards zero or towards the rendered force
  kPunctured,     // the puncture cue
  kBlending,      // between two local models
  kBeyondModel,   // farther than the local model's valid radius
  kPassivity,     // damped: the port had given out more energy than it took
  kClamped,       // the force limit
  kNotFinite,     // a force that was no number, replaced by zero
  kBadState,      // a state with impossible numbers, ignored
  kBadDevice,     // a device reading with impossible numbers, the last good one held
};
inline constexpr std::size_t kReasonCount = 13;

// As written in the log: `stale`, `clamped`, ...
std::string_view ToString(Reason reason);

class Reasons {
 public:
  void Add(Reason r) noexcept { bits_ = static_cast<std::uint16_t>(bits_ | Bit(r)); }
  [[nodiscard]] bool Has(Reason r) const noexcept { return (bits_ & Bit(r)) != 0; }
  [[nodiscard]] bool empty() const noexcept { return bits_ == 0; }

 private:
  static std::uint16_t Bit(Reason r) noexcept {
    return static_cast<std::uint16_t>(1U << static_cast<unsigned>(r));
  }
  std::uint16_t bits_ = 0;
};

// Joined by `+`; empty: nothing changed it.
std::string ToString(const Reasons& reasons);

struct ForceChain {
  Eigen::Vector3d estimated{0, 0, 0};  // newest state's force, S [N]; see force_known
  Eigen::Vector3d local{0, 0, 0};      // rendered at this tick, S [N]
  Eigen::Vector3d scaled{0, 0, 0};     // T^F of it, M [N], as all below
  Eigen::Vector3d passive{0, 0, 0};    // after the passivity control
  Eigen::Vector3d limited{0, 0, 0};    // finite and within the limit
  Eigen::Vector3d sent{0, 0, 0};       // after fading: what the device got
  bool force_known = false;            // `estimated` is a number
  Reasons reasons;
};

// `force` if it is finite and at most `limit` [N] long, else zero or shortened, with the reason.
// Real-time safe.
Eigen::Vector3d LimitForce(const Eigen::Vector3d& force, double limit, Reasons* reasons) noexcept;

}  // namespace palpate
