// Readings minus the mean of the first samples, as the authors of the networks took them.
#pragma once

#include <array>

#include "slave/tactile/signals/tactile_signals.h"

namespace palpate {

// The mean of a fingertip's first samples.
class RestValues {
 public:
  explicit RestValues(int samples) : wanted_(samples) {}

  // Adds one more sample while the baseline is incomplete.
  void Take(const FingerReading& reading) noexcept {
    if (known()) return;
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      sum_[i] += static_cast<double>(reading.channels[i]);
    }
    sum_[kElectrodeCount] += static_cast<double>(reading.pac);
    sum_[kElectrodeCount + 1] += static_cast<double>(reading.pdc);
    ++taken_;
  }
  [[nodiscard]] bool known() const noexcept { return taken_ >= wanted_; }
  void Reset() noexcept { sum_.fill(0), taken_ = 0; }
  // Returns counts minus rest values. Call only when the rest values are known.
  [[nodiscard]] TactileSignals Change(const FingerReading& reading) const noexcept {
    TactileSignals change{};
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      change[i] = Minus(reading.channels[i], sum_[i]);
    }
    change[kElectrodeCount] = Minus(reading.pac, sum_[kElectrodeCount]);
    change[kElectrodeCount + 1] = Minus(reading.pdc, sum_[kElectrodeCount + 1]);
    return change;
  }

 private:
  [[nodiscard]] double Minus(float value, double sum) const noexcept {
    return static_cast<double>(value) - sum / taken_;
  }

  int wanted_;
  int taken_ = 0;
  std::array<double, kSignalCount> sum_{};
};

}  // namespace palpate
