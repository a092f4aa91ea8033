// What becomes of a force on its way from the slave to the hand, one value per station, and why it
// changed: the view that answers "I enabled feedback but feel nothing". And the stations after the
// renderer: passivity, limit, blending. What is bounded here is bounded by the master alone: no
// word of the slave's can raise it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
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
  kSlewed,        // the force would have changed faster than the hand may feel it
  kProjected,     // the slave's stiffness was no spring that can be shown stably: made one
  kOffsetJump,    // the slave moved the offset within an epoch
  kSettings,      // the slave's settings are not those that were read
  kAged,          // sensed too long ago, or in the future
  kEnded,         // the slave's stream ended
  kPlane,         // off the patch, which is known: the plane of the states instead
  kHeld,          // the model was worse than the last force held, which is shown instead
  kArmFault,      // the slave's arm does not move: its driver is silent or tells of a fault
  kTared,         // less what was felt without contact when the operator asked for it
};
inline constexpr std::size_t kReasonCount = 23;

// As written in the log: `stale`, `clamped`, ...
std::string_view ToString(Reason reason);

class Reasons {
 public:
  void Add(Reason r) noexcept { bits_ |= Bit(r); }
  void Add(const Reasons& others) noexcept { bits_ |= others.bits_; }
  [[nodiscard]] bool Has(Reason r) const noexcept { return (bits_ & Bit(r)) != 0; }
  [[nodiscard]] bool empty() const noexcept { return bits_ == 0; }

 private:
  static std::uint32_t Bit(Reason r) noexcept { return 1U << static_cast<unsigned>(r); }
  std::uint32_t bits_ = 0;
};

// Joined by `+`; empty: nothing changed it.
std::string ToString(const Reasons& reasons);
// The same for people: `other epoch, fading`.
std::string InWords(const Reasons& reasons);

struct ForceChain {
  Eigen::Vector3d estimated{0, 0, 0};  // newest state's force, S [N]; see force_known
  Eigen::Vector3d local{0, 0, 0};      // rendered at this tick, S [N]
  Eigen::Vector3d scaled{0, 0, 0};     // T^F of it, M [N], as all below
  Eigen::Vector3d passive{0, 0, 0};    // after the passivity control
  Eigen::Vector3d limited{0, 0, 0};    // finite and within the limit
  Eigen::Vector3d sent{0, 0, 0};       // after fading and the slew limit: what the device got
  bool force_known = false;            // `estimated` is a number
  Reasons reasons;
};

// `force` if it is finite and at most `limit` [N] long, else zero or shortened, with the reason.
// Real-time safe.
Eigen::Vector3d LimitForce(const Eigen::Vector3d& force, double limit, Reasons* reasons) noexcept;

// Watches the energy at the device's port and damps when the port has given out more than it took:
// one-port time-domain passivity (Hannaford & Ryu 2002).
//
//   W += -f . dp + c,   c = -(f' - f) . dp / 2,   |c| <= b |dp|^2 / dt
//   W < -W_0 / 2:  f' -= alpha v,   alpha = min(-W / (dt |v|^2), alpha_max),   at most |f'|
//
// dp: motion since the last tick, f: force held meanwhile, f': the next one. The force is held
// between ticks, so -f . dp is its work exactly. c is what a spring leaks by being held, which
// physical damping `b` of device and hand eats: a spring K shown every T needs b >= K T / 2 to be
// passive (Colgate & Schenkel 1994; reference f, passivity_virtual_wall), so up to
// K = 2 b / T = 2000 N/m at 1 kHz nothing is ever damped; held for longer it leaks more, and that
// is damped once it is W_0 / 2. What else b eats pays for no force: a
// slave that shows next to nothing while the hand moves would save it up for a push. While no force
// is shown W is at most zero. A contact that is taken up pressed (a clutch closed again inside)
// gives back what this port took from the hand before, and no more: the slave's word is worth no
// energy. Limiting by |f| lets the damping weaken a force, never turn it round.
//
// Damping alone lets out what its alpha_max does not reach, so a force is shown only as far as W
// pays for it:
//
//   W + W_0 >= max(f^2 / 2 K_max,  f^2 v / 2 s + a f^3 / 6 s^2),   K_max = 2 b / T
//
// A spring of at most K_max that the hand wound up itself is not touched, since W >= f^2 / 2 K. The
// second is what comes out while the force falls by the slew limit `s` under a hand that gives way
// at speed `v`, ever faster by `a`, as measured: a spring whose force must fall quicker is
// weakened. W_0 is what is lent to a surface that moves by itself, and hence all that a slave can
// give out: it is paid back by the damping, and where nothing is shown by b within kLentAnew; and
// it is lent anew to a hand that engages anew, or a contact taken up pressed would stay unfelt.
// What was given out beyond it (less than a tick's work) b pays at once: without a force no hand
// could.
class PassivityControl {
 public:
  static constexpr double kPhysicalDamping = 1.0;  // b [N s/m]
  static constexpr double kMaxDamping = 50.0;      // alpha_max [N s/m]
  static constexpr double kLent = 0.5e-3;          // W_0 [J]
  static constexpr double kLentAnew = 60;          // [s]
  static constexpr double kMaxStiffness = 2000;    // K_max at 1 kHz [N/m]
  static constexpr double kUndamped = kLent / 2;   // of a debt: small ones fade without [J]
  static constexpr double kSmooth = 0.002;         // of a, a hand's: encoders count [s]

  // The device was at `p_M` [m] after `dt` > 0 [s] under the force that was held, `f_M` [N].
  // Real-time safe.
  void Observe(const Eigen::Vector3d& p_M, const Eigen::Vector3d& f_M, double dt) noexcept;
  // The hand engages anew, of its own will: W_0 is lent anew. Real-time safe.
  void Lend() noexcept { balance_ = std::max(balance_, 0.0); }
  // The hand takes up a contact: what it put into the last one and did not get back may come out.
  // Real-time safe.
  void Restore() noexcept {
    balance_ += stored_;
    stored_ = 0;
  }
  // `f_M` [N], damped against `v_M` [m/s] if energy is missing. Real-time safe.
  [[nodiscard]] Eigen::Vector3d Apply(const Eigen::Vector3d& f_M, const Eigen::Vector3d& v_M,
                                      double dt) const noexcept;
  // `f_M` [N] as far as the balance pays for it while the hand moves at `v_M` [m/s] and the force
  // falls by at most `slew` [N/s]; where it does not pay for what is held yet, only that falls, by
  // the shortest way. Real-time safe.
  [[nodiscard]] Eigen::Vector3d Afford(const Eigen::Vector3d& f_M, const Eigen::Vector3d& v_M,
                                       double slew) const noexcept;
  [[nodiscard]] double balance() const noexcept { return balance_; }        // W [J]
  [[nodiscard]] double min_balance() const noexcept { return min_; }        // least W ever [J]
  [[nodiscard]] double energy_in() const noexcept { return energy_in_; }    // from the hand [J]
  [[nodiscard]] double energy_out() const noexcept { return energy_out_; }  // to the hand [J]
  // The most that the hand had got beyond what it had put in, negative [J]: with what b eats.
  [[nodiscard]] double min_work() const noexcept { return min_work_; }

 private:
  // `f_M` [N], were there nothing else.
  [[nodiscard]] Eigen::Vector3d PaidFor(const Eigen::Vector3d& f_M, const Eigen::Vector3d& v_M,
                                        double slew) const noexcept;
  // c, if the next force is `f_M` [J].
  [[nodiscard]] double Leak(const Eigen::Vector3d& f_M) const noexcept;

  Eigen::Vector3d last_p_{0, 0, 0}, last_dp_{0, 0, 0}, held_{0, 0, 0};
  Eigen::Vector3d last_v_{0, 0, 0}, acceleration_{0, 0, 0};
  double last_dt_ = 1;
  bool moved_ = false, shown_ = false;
  double balance_ = 0, min_ = 0, energy_in_ = 0, energy_out_ = 0, min_work_ = 0;
  double stored_ = 0;  // put in and not given back when the last force ended [J]
};

// The last station before the device: goes over from what the hand feels now to what it shall feel,
// never in a step, whatever comes. Always between the two, hence within the limit if both are.
class OutputBlend {
 public:
  // The force changes by at most `slew` [N/s], both ways: a limit on its rise alone would make a
  // limit cycle.
  explicit OutputBlend(double slew = std::numeric_limits<double>::infinity()) : slew_(slew) {}

  enum class Target : std::uint8_t {
    kZero,      // nothing
    kRendered,  // what is given to Step
    kFrozen,    // what was sent when this began
  };
  // From what was sent last to `target` in `duration` [s] >= 0. Real-time safe.
  void Go(Target target, double duration) noexcept;
  // On the way to the target, `dt` [s] after the last [N]. Real-time safe.
  Eigen::Vector3d Wanted(const Eigen::Vector3d& rendered, double dt) noexcept;
  // The force to send [N] where `wanted` is; of a longer `dt` [s] than a tick no more is made for
  // the slew limit. Real-time safe.
  Eigen::Vector3d Send(const Eigen::Vector3d& wanted, double dt) noexcept;
  // The last step was as long as one may be.
  [[nodiscard]] bool is_slewed() const noexcept { return is_slewed_; }
  [[nodiscard]] bool is_blending() const noexcept { return elapsed_ < duration_; }

 private:
  static constexpr double kTick = 0.001;  // [s]

  double slew_;  // [N/s]
  bool is_slewed_ = false;
  Target target_ = Target::kZero;
  Eigen::Vector3d from_{0, 0, 0}, sent_{0, 0, 0};
  double duration_ = 0, elapsed_ = 0;
};

}  // namespace palpate
