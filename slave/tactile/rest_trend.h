// The baseline of a fingertip and its drift, extrapolated during contact, when it cannot be
// measured, and steps of all electrodes, which no contact causes.
#pragma once

#include <array>

#include "slave/tactile/signals/rest_values.h"

namespace palpate {

// Each signal goes on as its baseline did without contact, older samples counting less:
//
//   x(t) = level + slope h(t),   h(t) = (1 - exp(-k t)) / k,   t from the last sample taken,
//
// a line where k is 0, and the end of a line where a fingertip warms up. The slopes are used as far
// as the electrodes' together stand out of their noise (W. James and C. Stein, 4th Berkeley
// Symposium, 1961): fingertips at their temperature have none, and theirs would be noise alone. k
// is that of all signals, by how their slopes changed.
class RestTrend {
 public:
  // The first `samples` are without contact; `rate` of all [Hz].
  explicit RestTrend(int samples, double rate = 100) : wanted_(samples), rate_(rate) {}

  void Reset() noexcept { *this = RestTrend(wanted_, rate_); }
  [[nodiscard]] bool known() const noexcept { return taken_ >= wanted_; }

  // Advances by one sample period. Call before Take.
  void Advance() noexcept;
  // Processes a sample without contact; earlier samples keep the part `keep` of their weight [0,
  // 1].
  void Take(const FingerReading& reading, double keep = 1) noexcept;
  // Processes a sample while nothing is near enough to touch.
  void Follow(const FingerReading& reading) noexcept;
  // All electrodes have moved by this at once, and will stay there [counts].
  void Shift(double by) noexcept;
  // Processes every sample. `looks_back`: it follows the last one without a gap.
  void FollowSteps(const FingerReading& reading, bool looks_back) noexcept;
  // How many steps all electrodes have made together, lately.
  [[nodiscard]] double steps() const { return steps_; }

  // Counts minus rest of a sample `ago` samples before the last one. Call when known.
  [[nodiscard]] TactileSignals Change(const FingerReading& reading, double ago = 0) const noexcept;
  // Variance of an electrode's present baseline, beyond that of a fingertip without drift
  // [counts^2].
  [[nodiscard]] double variance() const noexcept;
  // Of the pressure's [counts^2].
  [[nodiscard]] double pressure_variance() const noexcept;
  // Uncertainty of all signals because k is unknown: one sigma, with a common sign [counts].
  [[nodiscard]] TactileSignals astray() const noexcept;

 private:
  // Sums over the samples, of t^n and of t^n x [samples^n, counts]; t from now.
  struct Moments {
    std::array<double, 3> timed{};
    double squared = 0;  // of x^2
  };
  struct Line {
    double level = 0, slope = 0;  // at the last sample taken [counts], [counts/sample]
  };
  // Means over the samples, with regard to time.
  struct Times {
    double middle = 0, spread = 0;  // [samples], [samples^2]
    double skew = 0, beyond = 0;    // of q = s^2 - skew s - spread, s = t - middle: mean of q^2
  };

  // Time for which the slopes are extrapolated after the last sample [samples]: limited, so that
  // their noise does not grow during long contacts.
  [[nodiscard]] double Ahead() const noexcept;
  // h, t samples after the last one taken, or before it.
  [[nodiscard]] double Way(double t) const noexcept;
  [[nodiscard]] Times TimesNow() const noexcept;
  void Fit() noexcept;
  void FitBend(const Times& times) noexcept;
  void FitLines() noexcept;

  int wanted_;
  double rate_;
  int taken_ = 0, since_ = 0;                         // samples, since the last one taken
  std::array<double, 5> times_{};                     // sums of t^n [samples^n]
  double bend_ = 0, bend_sigma_ = 0;                  // k [1/sample]
  double noise2_ = 0;                                 // of an electrode [counts^2]
  double part_ = 0;                                   // of the slopes that is used
  double slope_variance_ = 0;                         // [counts^2/sample^2]
  double middle_ = 0;                                 // mean of h [samples]
  double pressure_noise2_ = 0, pressure_slope2_ = 0;  // [counts^2], times [1/sample^2]
  FingerReading origin_;
  std::array<Moments, kSignalCount> moments_{};
  std::array<Line, kSignalCount> lines_{};
  TactileSignals clear_{};                       // mean change while clear [counts]
  std::array<float, kElectrodeCount> before_{};  // electrodes of the last sample
  double steps_ = 0;
};

}  // namespace palpate
