// The force chain: the value of each step from the slave's estimate to the device, and the reasons
// of each change. Also the steps after the renderer: passivity, limit and blending. The master
// alone sets their bounds. No message of the slave can raise them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace palpate {

// Why the force of a tick differs from the slave's force.
enum class Reason : std::uint8_t {
  kNotFollowing,  // the operator is not engaged: the force is zero
  kStale,         // no state for the link timeout (30 ms)
  kUnknown,       // the slave does not know the force
  kOtherEpoch,    // the slave no longer serves this engagement
  kFading,        // the force moves to zero or to the rendered force
  kPunctured,     // the tool broke through the surface
  kBlending,      // two local models are blended
  kBeyondModel,   // outside the valid radius of the local model
  kPassivity,     // damped: more energy was returned to the operator than received
  kClamped,       // the force limit applies
  kNotFinite,     // the force is not a number; replaced by zero
  kBadState,      // a state has impossible numbers; ignored
  kBadDevice,     // a reading has impossible numbers; the last good one is used
  kSlewed,        // the slew limit applies
  kProjected,     // the slave's stiffness was replaced by the nearest stable spring
  kOffsetJump,    // the slave moved the position offset within an epoch
  kSettings,      // the slave's settings differ from those that were read
  kAged,          // the sample is too old, or its timestamp is in the future
  kEnded,         // the slave closed the stream
  kPlane,         // outside the known patch: the plane of the states is used
  kHeld,          // the newest force is held, because the model was worse
  kArmFault,      // the manipulator's driver is silent or reports a fault
  kTared,         // the tare was subtracted
  kFixture,       // a lock, the box, a fixture or the speed limit acts
};
inline constexpr std::size_t kReasonCount = 24;

// Returns the name that the log contains: `stale`, `clamped`, ...
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

// Returns the names of the reasons, joined by `+`; empty without a reason.
std::string ToString(const Reasons& reasons);
// Returns all reasons as text for people: `other epoch, fading`.
std::string InWords(const Reasons& reasons);

struct ForceChain {
  Eigen::Vector3d estimated{0, 0, 0};  // newest state's force, S [N]; see force_known
  Eigen::Vector3d local{0, 0, 0};      // rendered at this tick, S [N]
  // After force scale, rotation, locks, box and fixtures, M [N], like those below.
  Eigen::Vector3d scaled{0, 0, 0};
  Eigen::Vector3d passive{0, 0, 0};  // after the passivity control
  Eigen::Vector3d limited{0, 0, 0};  // finite and within the limit
  Eigen::Vector3d sent{0, 0, 0};     // after fading and the slew limit: the force on the device
  bool force_known = false;          // `estimated` is a number
  Reasons reasons;
};

// Returns `force` if it is finite and at most `limit` [N] long. Otherwise returns zero or the
// shortened force, and adds the reason. Real-time safe.
Eigen::Vector3d LimitForce(const Eigen::Vector3d& force, double limit, Reasons* reasons) noexcept;

// Observes the energy at the device's port, and damps when the port has returned more than it
// received: one-port time-domain passivity (Hannaford & Ryu 2002).
//
//   W += -f . dp + c,   c = -(f' - f) . dp / 2,   |c| <= b |dp|^2 / dt
//   W < -W_0 / 2:  f' -= alpha v,   alpha = min(-W / (dt |v|^2), alpha_max),   at most |f'|
//
// dp: motion since the last tick, f: force during it, f': the next force. The force is constant
// between ticks, so -f . dp is its exact work. c is the energy that a sampled spring leaks. The
// physical damping `b` of device and operator dissipates it: a spring K with period T is passive if
// b >= K T / 2 (Colgate & Schenkel 1994; reference f, passivity_virtual_wall). Therefore nothing is
// damped up to K = 2 b / T = 2000 N/m at 1 kHz. A longer period leaks more, which is damped from
// W_0 / 2 on. Other energy dissipated by b is not credited: a slave that renders almost nothing
// during motion could save it for a push. While no force is rendered, W is at most zero. A contact
// that begins pressed (the clutch closes inside the object) returns at most the energy that this
// port received before. Limiting by |f| lets the damping weaken a force but never reverse it.
//
// Damping is bounded by alpha_max, so the force is also limited to what W covers:
//
//   W + W_0 >= max(f^2 / 2 K_max,  f^2 v / 2 s + a f^3 / 6 s^2),   K_max = 2 b / T
//
// A spring of at most K_max that the operator compressed is not affected, since W >= f^2 / 2 K. The
// second term is the energy released while the force falls at the slew limit `s` and the device
// yields at the measured speed `v` and acceleration `a`: a spring that must release faster is
// weakened. W_0 is the credit for a surface that moves by itself, and so the most that a slave can
// release. Damping repays it; without a force b repays it within kRepayTime. Each new engagement
// renews it, because a contact that begins pressed would otherwise have no force. Energy released
// beyond it (less than the work of a tick) is repaid by b at once.
class PassivityControl {
 public:
  static constexpr double kPhysicalDamping = 1.0;         // b [N s/m]
  static constexpr double kMaxDamping = 50.0;             // alpha_max [N s/m]
  static constexpr double kEnergyCredit = 0.5e-3;         // W_0 [J]
  static constexpr double kRepayTime = 60;                // [s]
  static constexpr double kMaxStiffness = 2000;           // K_max at 1 kHz [N/m]
  static constexpr double kUndamped = kEnergyCredit / 2;  // a smaller debt is not damped [J]
  static constexpr double kSmooth = 0.002;  // smoothing time of a, against encoder steps [s]

  // Sets the largest damping of the device, if it is below kMaxDamping [N s/m]. Call it first.
  void set_max_damping(double most) noexcept { max_damping_ = std::min(most, kMaxDamping); }
  // Adds a tick: the device is at `p_M` [m] after `dt` > 0 [s] under the force `f_M` [N]. Real-time
  // safe.
  void Observe(const Eigen::Vector3d& p_M, const Eigen::Vector3d& f_M, double dt) noexcept;
  // Renews the credit W_0 at a new engagement. Real-time safe.
  void RenewCredit() noexcept { balance_ = std::max(balance_, 0.0); }
  // Credits the energy that the last contact received and did not return, when a contact begins
  // pressed. Real-time safe.
  void CreditStored() noexcept {
    balance_ += stored_;
    stored_ = 0;
  }
  // Returns `f_M` [N], damped against `v_M` [m/s] if energy is missing. Real-time safe.
  [[nodiscard]] Eigen::Vector3d Apply(const Eigen::Vector3d& f_M, const Eigen::Vector3d& v_M,
                                      double dt) const noexcept;
  // Returns `f_M` [N], limited to what the balance covers while the device moves at `v_M` [m/s] and
  // the force falls by at most `slew` [N/s]. If it does not even cover the present force, that
  // force falls by the shortest path. Real-time safe.
  [[nodiscard]] Eigen::Vector3d LimitToBalance(const Eigen::Vector3d& f_M,
                                               const Eigen::Vector3d& v_M,
                                               double slew) const noexcept;
  [[nodiscard]] double balance() const noexcept { return balance_; }        // W [J]
  [[nodiscard]] double min_balance() const noexcept { return min_; }        // least W ever [J]
  [[nodiscard]] double energy_in() const noexcept { return energy_in_; }    // from the operator [J]
  [[nodiscard]] double energy_out() const noexcept { return energy_out_; }  // to the operator [J]
  // Returns the minimum of the energy from the operator minus the energy returned, at most 0 [J].
  [[nodiscard]] double min_work() const noexcept { return min_work_; }

 private:
  // `f_M` [N], limited by the balance alone.
  [[nodiscard]] Eigen::Vector3d WithinBalance(const Eigen::Vector3d& f_M,
                                              const Eigen::Vector3d& v_M,
                                              double slew) const noexcept;
  // c, if the next force is `f_M` [J].
  [[nodiscard]] double Leak(const Eigen::Vector3d& f_M) const noexcept;

  Eigen::Vector3d last_p_{0, 0, 0}, last_dp_{0, 0, 0}, held_{0, 0, 0};
  Eigen::Vector3d last_v_{0, 0, 0}, acceleration_{0, 0, 0};
  double last_dt_ = 1;
  bool has_position_ = false;    // Observe was called before
  bool rendered_force_ = false;  // in the last tick
  double balance_ = 0, min_ = 0, energy_in_ = 0, energy_out_ = 0, min_work_ = 0;
  double stored_ = 0;  // energy received and not returned when the last force ended [J]
  double max_damping_ = kMaxDamping;  // [N s/m]
};

// The last step before the device: moves from the present to the target force without a jump. The
// result is always between the two, so it is within the limit if both are.
class OutputBlend {
 public:
  // The force changes by at most `slew` [N/s] in both directions. A limit on the rise alone would
  // cause a limit cycle.
  explicit OutputBlend(double slew = std::numeric_limits<double>::infinity()) : slew_(slew) {}

  enum class Target : std::uint8_t {
    kZero,      // no force
    kRendered,  // the rendered force
    kFrozen,    // the force that was sent when the transition began
  };
  // Starts a transition from the last sent force to `target`, of `duration` [s] >= 0. If a
  // transition to zero runs that ends before this one would, it continues. Real-time safe.
  void Go(Target target, double duration) noexcept;
  // The force is zero from now on, at once: the device has dropped it. Real-time safe.
  void Drop() noexcept;
  // The force of the transition, `dt` [s] after the last call [N]. Real-time safe.
  Eigen::Vector3d Wanted(const Eigen::Vector3d& rendered, double dt) noexcept;
  // The force to send [N] toward `wanted`. The slew limit uses `dt` [s], but at most one tick.
  // Real-time safe.
  Eigen::Vector3d Send(const Eigen::Vector3d& wanted, double dt) noexcept;
  // Returns whether the slew limit applied in the last step.
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
