// The baseline of a fingertip and its drift, extrapolated during contact, when it cannot be
// measured.
#pragma once

#include <array>

#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// BaselineSensor describes the sensor of a baseline.
struct BaselineSensor {
  std::size_t channels = kElectrodeCount;
  double noise = 1;          // rms of a channel at rest [its unit]
  bool has_pressure = true;  // the sensor has a pressure, which rises with every contact
};

// Recursive mean with drift: for each signal a line by weighted least squares over the samples
// without contact, where older samples have less weight,
//
//   x(t) = level + slope t,   t from the last sample used.
//
// The slopes are shrunk according to their noise (W. James and C. Stein, 4th Berkeley Symposium,
// 1961), because without drift they are only noise.
class Baseline {
 public:
  // The first `samples` are without contact; `rate` of all [Hz].
  explicit Baseline(int samples, double rate = 100, const BaselineSensor& sensor = {})
      : wanted_(samples), rate_(rate), sensor_(sensor) {
    clear_.resize(signals());
  }

  void Reset() noexcept { *this = Baseline(wanted_, rate_, sensor_); }
  [[nodiscard]] bool known() const noexcept { return taken_ >= wanted_; }

  // Advances by one sample period. Call before Take.
  void Advance() noexcept;
  // Processes a sample without contact; earlier samples keep the part `keep` of their weight [0,
  // 1].
  void Take(const FingerReading& reading, double keep = 1) noexcept;
  // Processes a sample while contact is impossible.
  void Follow(const FingerReading& reading) noexcept;
  // Returns the counts minus baseline of a sample `ago` samples before the last one. Call when
  // known.
  [[nodiscard]] TactileSignals Change(const FingerReading& reading, double ago = 0) const noexcept;
  // Variance of an electrode's present baseline, beyond that of a fingertip without drift
  // [counts^2].
  [[nodiscard]] double variance() const noexcept;
  // Variance of the pressure's present baseline [counts^2].
  [[nodiscard]] double pressure_variance() const noexcept;
  // Returns the time since the last sample taken [s].
  [[nodiscard]] double age() const noexcept { return since_ / rate_; }
  // The largest rms distance of a channel from its line [its unit].
  [[nodiscard]] double spread() const noexcept { return spread_; }
  // Returns one sigma of the drift's continuation, of all signals with a common sign [counts].
  [[nodiscard]] TactileSignals drift_sigma() const noexcept;

 private:
  [[nodiscard]] std::size_t signals() const noexcept { return sensor_.channels + 2; }
  // Weighted sums over the samples: of x, of t x and of x^2, t from now [counts, samples].
  struct Sums {
    double x = 0, tx = 0, xx = 0;
  };
  struct Line {
    double level = 0, slope = 0;  // at the last sample taken [counts], [counts/sample]
  };

  // Time for which the slopes are extrapolated [samples]: limited, so that their noise does not
  // grow during long contacts.
  [[nodiscard]] double Ahead() const noexcept;
  void Fit() noexcept;

  int wanted_;
  double rate_;
  BaselineSensor sensor_;
  int taken_ = 0, since_ = 0;      // samples, since the last one taken
  double n_ = 0, t_ = 0, tt_ = 0;  // weighted sums of 1, t and t^2 [samples^k]
  double drift_variance_ = 0;      // of an electrode's slope [counts^2/sample^2]
  double middle_ = 0;              // mean of t [samples]
  double spread_ = 0;              // [unit of the channels]
  double pressure_noise2_ = 0;     // [counts^2]
  double pressure_slope2_ = 0;     // variance of its slope, over pressure_noise2_ [1/sample^2]
  FingerReading origin_;
  std::array<Sums, kMaxChannels + 2> sums_{};
  std::array<Line, kMaxChannels + 2> lines_{};
  TactileSignals clear_{};  // mean change while clear [counts]
};

}  // namespace palpate
