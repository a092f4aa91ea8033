// SignalModel is a Gaussian model of a fingertip's signals in contact. It measures how far signals
// are from those of a contact, and estimates the correct value of a wrong signal.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "slave/tactile/electrode_jumps.h"
#include "slave/tactile/signal_noise.h"
#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Signals x of a contact of size a and of one of the pattern's kinds are normally distributed with
// zero mean and covariance
//
//   S = a² shape + N + q² 1 1' + w w',   N = diag(n²),
//
// where n is the noise from sample to sample, q the common drift of all electrodes, and w one sigma
// of the baseline's drift. The kind is the one with the largest likelihood. A signal differs from
// its expectation given all others by (S⁻¹ x)_i / (S⁻¹)_ii, with variance 1 / (S⁻¹)_ii. An
// electrode that differs by more than 5.5 standard deviations is replaced by the expectation, and
// so is an electrode that jumps (ElectrodeJumps). Noise and drift N' beyond the usual amount are
// removed: x - (N' + q² 1 1' + w w') S⁻¹ x.
//
// The model cannot detect errors that another contact could cause: a wrong signal within the
// tolerance of 2 to 10 percent of the signals' size, or all signals larger by the same factor. A
// wrong gain amplifies the noise, too, so unusual noise may indicate such a factor.
class SignalModel {
 public:
  using Signals = SignalPattern::Signals;
  using Covariance = SignalPattern::Covariance;

  // `rate` is the sample rate [Hz], > 0. The pattern must be known.
  SignalModel(const SignalPattern& pattern, double rate);

  // Processes the next sample `change`: counts minus baseline. `is_dead` flags electrodes that do
  // not work, and `is_still` those that may not. `baseline2` is the variance of each electrode's
  // baseline [counts^2], `baseline_drift` is w [counts]. Does not allocate.
  void Update(const TactileSignals& change, const Electrodes& is_dead, const Electrodes& is_still,
              double baseline2, const TactileSignals& baseline_drift = {}) noexcept;
  void Reset() noexcept;

  // Returns the corrected signals of the last sample.
  [[nodiscard]] const TactileSignals& corrected() const { return corrected_; }
  [[nodiscard]] bool is_replaced(std::size_t electrode) const { return is_wrong_[electrode]; }
  [[nodiscard]] int replaced() const { return replaced_; }  // electrodes
  // Returns the squared Mahalanobis distance of the signals divided by their number; its mean is
  // 1 [-].
  [[nodiscard]] double mahalanobis2() const { return mahalanobis2_; }
  // Returns the pressure minus its expectation given the electrodes [standard deviations].
  [[nodiscard]] double pressure_residual() const { return pressure_residual_; }
  // Returns the index of the last sample's kind of contact in SignalPattern::kinds.
  [[nodiscard]] std::size_t kind() const { return kind_; }
  // Returns the common drift of all electrodes [counts].
  [[nodiscard]] double drift() const { return drift_; }
  // Returns the standard deviation of the force by noise, drift and replaced signals [N].
  [[nodiscard]] double force_sigma() const { return force_sigma_; }
  [[nodiscard]] const SignalNoise& noise() const { return noise_; }

 private:
  struct Kind {
    Covariance shape;
    double offset = 0;   // - 2 log(share)
    Covariance inverse;  // inverse of S at a typical size, which selects the candidates
    double log_det = 0;  // log |S| at the typical size
  };
  static constexpr std::size_t kCandidates = 3;  // kinds that are evaluated with their own S

  // Returns the most likely kinds at a typical size. `unit` holds the signals divided by their
  // size.
  [[nodiscard]] std::array<std::size_t, kCandidates> Candidates(const Signals& unit) const noexcept;
  // Sets kind_ and returns S⁻¹. `other` is S without a² shape.
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
