// Gaussian model of a fingertip's signals in contact: how far they are from what a contact does,
// and what a signal that is wrong should have been.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "slave/tactile/electrode_jumps.h"
#include "slave/tactile/signal_noise.h"
#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Signals x of a contact of size a and one of the pattern's kinds are normal, with covariance
//
//   S = a² shape + N + q² 1 1' + w w',   N = diag(n²),
//
// n the noise measured from sample to sample, q the common drift of all electrodes, w one sigma of
// the baseline's drift. The kind is that of the largest likelihood. A signal differs from its
// expectation given all others by (S⁻¹ x)_i / (S⁻¹)_ii, of the variance 1 / (S⁻¹)_ii. An electrode
// beyond 5.5 of these is replaced by the expectation; so is one that jumps (ElectrodeJumps).
// Noise and drift beyond the usual, N', are removed: x - (N' + q² 1 1' + w w') S⁻¹ x.
//
// It cannot see what another contact could have done: a wrong signal within its tolerance of 2 to
// 10 percent of the signals' size, or all signals larger by the same factor. Noise is amplified
// like signals: where it is not the usual one, that factor may be what it says.
class SignalModel {
 public:
  using Signals = SignalPattern::Signals;
  using Covariance = SignalPattern::Covariance;

  // `rate` of the samples [Hz], > 0. The pattern must be known.
  SignalModel(const SignalPattern& pattern, double rate);

  // Processes the next sample, counts minus baseline; `is_dead`: electrodes that do not work;
  // `is_still`: those that may not; `baseline2`: variance of each electrode's baseline [counts^2];
  // `baseline_drift`: w [counts]. Allocation-free.
  void Update(const TactileSignals& change, const Electrodes& is_dead, const Electrodes& is_still,
              double baseline2, const TactileSignals& baseline_drift = {}) noexcept;
  void Reset() noexcept;

  // Signals of the last sample to use.
  [[nodiscard]] const TactileSignals& corrected() const { return corrected_; }
  [[nodiscard]] bool is_replaced(std::size_t electrode) const { return is_wrong_[electrode]; }
  [[nodiscard]] int replaced() const { return replaced_; }  // electrodes
  // Squared Mahalanobis distance of the signals over their number: 1 in the mean [-].
  [[nodiscard]] double mahalanobis2() const { return mahalanobis2_; }
  // Pressure minus its expectation given the electrodes, in standard deviations [-].
  [[nodiscard]] double pressure_residual() const { return pressure_residual_; }
  // Kind of contact of the last sample, in SignalPattern::kinds.
  [[nodiscard]] std::size_t kind() const { return kind_; }
  // Common drift of all electrodes [counts].
  [[nodiscard]] double drift() const { return drift_; }
  // Error of the force by noise, drift and replaced signals, one sigma [N].
  [[nodiscard]] double force_sigma() const { return force_sigma_; }
  [[nodiscard]] const SignalNoise& noise() const { return noise_; }

 private:
  struct Kind {
    Covariance shape;
    double offset = 0;   // - 2 log(share)
    Covariance inverse;  // of S at a typical size, by which candidates are chosen
    double log_det = 0;  // log |S| there
  };
  static constexpr std::size_t kCandidates = 3;  // kinds that are evaluated with their own S

  // `unit`: signals by their size. The most likely kinds at a typical size.
  [[nodiscard]] std::array<std::size_t, kCandidates> Candidates(const Signals& unit) const noexcept;
  // Sets kind_; returns S⁻¹. `other`: S without a² shape.
  Covariance ChooseKind(const Signals& x, double size2, const Covariance& other) noexcept;
  void ReplaceOutliers(const Signals& x, const Electrodes& is_still, Signals* noise2,
                       Covariance* inverse) noexcept;
  void TrackDrift(const Signals& x, const Covariance& inverse, const Signals& known) noexcept;
  void Correct(const TactileSignals& change, const Signals& x, const Covariance& excess,
               const Covariance& inverse) noexcept;

  std::vector<Kind> kinds_;
  Eigen::Matrix<double, 3, kPatternSignals> force_;  // of small signals [N/count]
  SignalNoise noise_;
  ElectrodeJumps jumps_;
  double share_;       // weight of a sample in the drift
  double drift2_ = 0;  // q² [counts^2]
  double drift_ = 0;
  Electrodes is_wrong_{};
  int replaced_ = 0;
  std::size_t kind_ = 0;
  double mahalanobis2_ = 1, pressure_residual_ = 0, force_sigma_ = 0;
  TactileSignals corrected_{};
};

}  // namespace palpate
