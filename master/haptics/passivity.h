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
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace palpate {

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

}  // namespace palpate
