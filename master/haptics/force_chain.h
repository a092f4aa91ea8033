// What becomes of a force on its way from the slave to the hand, one value per station, and why it
// changed: the view that answers "I enabled feedback but feel nothing". And the stations after the
// renderer: passivity, limit, blending.
#pragma once

#include <cmath>
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

// Watches the energy at the device's port and damps when the port has given out more than it took:
// one-port time-domain passivity (Hannaford & Ryu 2002).
//
//   W += -f . dp + b |dp|^2 / dt        dp: motion since the last tick, f: force held meanwhile
//   W < 0:  f -= alpha v,   alpha = min(-W / (dt |v|^2), alpha_max),   never more than |f|
//
// The force is held between ticks, so -f . dp is its work exactly. `b` is physical damping of
// device and hand that may be counted on: a spring K shown every T needs b >= K T / 2 to be passive
// (Colgate & Schenkel 1994; reference f, passivity_virtual_wall), so up to K = 2 b / T = 2000 N/m
// at 1 kHz nothing is ever damped. While no force is shown W is zero: what damping ate in free
// motion pays for nothing later. A contact that is taken up pressed (a clutch closed again inside)
// gives back what an earlier epoch put in. Limiting by |f| lets the damping weaken a force, never
// turn it round.
class PassivityControl {
 public:
  static constexpr double kPhysicalDamping = 1.0;  // b [N s/m]
  static constexpr double kMaxDamping = 50.0;      // alpha_max [N s/m]

  // The device was at `p_M` [m] after `dt` > 0 [s] under the force that was held, `f_M` [N].
  // Real-time safe.
  void Observe(const Eigen::Vector3d& p_M, const Eigen::Vector3d& f_M, double dt) noexcept;
  // The contact holds at least `energy` [J], put in before the hand took it up: it may come out.
  // Real-time safe.
  void Credit(double energy) noexcept { balance_ = std::fmax(balance_, energy); }
  // `f_M` [N], damped against `v_M` [m/s] if energy is missing. Real-time safe.
  [[nodiscard]] Eigen::Vector3d Apply(const Eigen::Vector3d& f_M, const Eigen::Vector3d& v_M,
                                      double dt) const noexcept;
  [[nodiscard]] double balance() const noexcept { return balance_; }        // W [J]
  [[nodiscard]] double min_balance() const noexcept { return min_; }        // least W ever [J]
  [[nodiscard]] double energy_in() const noexcept { return energy_in_; }    // from the hand [J]
  [[nodiscard]] double energy_out() const noexcept { return energy_out_; }  // to the hand [J]

 private:
  Eigen::Vector3d last_p_{0, 0, 0};
  bool moved_ = false;
  double balance_ = 0, min_ = 0, energy_in_ = 0, energy_out_ = 0;
};

// The last station before the device: goes over from what the hand feels now to what it shall feel,
// never in a step. Always between the two, hence within the limit if both are.
class OutputBlend {
 public:
  enum class Target : std::uint8_t {
    kZero,      // nothing
    kRendered,  // what is given to Step
    kFrozen,    // what was sent when this began
  };
  // From what was sent last to `target` in `duration` [s] >= 0. Real-time safe.
  void Go(Target target, double duration) noexcept;
  // The force to send [N], `dt` [s] after the last. Real-time safe.
  Eigen::Vector3d Step(const Eigen::Vector3d& rendered, double dt) noexcept;
  [[nodiscard]] bool is_blending() const noexcept { return elapsed_ < duration_; }

 private:
  Target target_ = Target::kZero;
  Eigen::Vector3d from_{0, 0, 0}, sent_{0, 0, 0};
  double duration_ = 0, elapsed_ = 0;
};

}  // namespace palpate
