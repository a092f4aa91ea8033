// Checks whether the signals of a fingertip match the pattern in the network's training data, and
// computes the expected value of a signal that does not.
#pragma once

#include <cstddef>

#include "slave/tactile/contact_kinds.h"
#include "slave/tactile/electrode_jumps.h"
#include "slave/tactile/signal_noise.h"
#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Signals x of a contact of size a and some kind are taken for normal, with covariance
//
//   S = a² shape + N + q² 1 1' + w w',   N = diag(n²),
//
// n the noise as it is measured from sample to sample, q how far all electrodes have drifted
// together, w how far the lines that the baseline went along may have left them. What each signal
// is expected to be from the others, and how far it may be from that, follows from the inverse of
// S. An electrode farther away is wrong: what is expected takes its place. Of noise and drift what
// is more than usual is taken off: x - (N' + q² 1 1' + w w') S⁻¹ x, N' the variance above the usual
// one.
//
// It cannot see what another contact could have done: a wrong signal within its tolerance of 2 to
// 10 percent of the signals' size, or all signals larger by the same factor. Noise is amplified
// like signals: where it is not the usual one, that factor may be what it says.
class PatternCheck {
 public:
  using Signals = SignalPattern::Signals;
  using Covariance = SignalPattern::Covariance;

  // `rate` of the samples [Hz], > 0. The pattern must be known.
  PatternCheck(const SignalPattern& pattern, double rate);

  // Processes the next sample, counts minus baseline; `is_dead`: electrodes known not to work;
  // `is_still`: those that may not; `rest2`: variance of each electrode's baseline [counts^2];
  // `astray`: w [counts]. Allocation-free.
  void Take(const TactileSignals& change, const Electrodes& is_dead, const Electrodes& is_still,
            double rest2, const TactileSignals& astray = {}) noexcept;
  void Reset() noexcept;

  // Signals of the last sample to use.
  [[nodiscard]] const TactileSignals& mended() const { return mended_; }
  [[nodiscard]] bool is_replaced(std::size_t electrode) const { return is_wrong_[electrode]; }
  [[nodiscard]] int replaced() const { return replaced_; }  // electrodes
  // Averaged over some samples: how far pressure and electrodes disagree, in standard deviations.
  [[nodiscard]] double disagreement() const { return disagreement_; }
  // Averaged over some samples: residual mismatch relative to its expected mean; about 1 if the
  // signals match.
  [[nodiscard]] double misfit() const { return misfit_; }
  // Of the last sample alone.
  [[nodiscard]] double misfit_now() const { return misfit_now_; }
  // Kind of contact of the last sample.
  [[nodiscard]] std::size_t kind() const { return kind_; }  // in SignalPattern::kinds
  // How far all electrodes have drifted together [counts].
  [[nodiscard]] double drift() const { return drift_; }
  // Contribution of noise, drift and replaced signals to the error of the force [N].
  [[nodiscard]] double force_sigma() const { return force_sigma_; }
  [[nodiscard]] const SignalNoise& noise() const { return noise_; }

 private:
  void LeaveOutWrong(const Signals& x, const Electrodes& is_still, Signals* noise2,
                     Covariance* inverse) noexcept;
  void Measure(const Signals& x, const Covariance& inverse) noexcept;
  // Covariance of the baseline's drift since it was measured.
  [[nodiscard]] Covariance Drift() const noexcept;
  void Mend(const TactileSignals& change, const Signals& x, const Signals& noise2,
            const Covariance& inverse) noexcept;

  ContactKinds kinds_;
  Eigen::Matrix<double, 3, kPatternSignals> force_;  // of small signals [N/count]
  SignalNoise noise_;
  ElectrodeJumps jumps_;
  double share_;       // weight of a sample in the drift
  Signals astray_;     // w [counts]
  double drift2_ = 0;  // q² [counts^2]
  Electrodes is_wrong_{};
  int replaced_ = 0;
  std::size_t kind_ = 0;
  double disagreement_ = 0, misfit_ = 0, misfit_now_ = 0;
  double drift_ = 0, force_sigma_ = 0;
  TactileSignals mended_{};
};

}  // namespace palpate
