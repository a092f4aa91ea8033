// Which electrodes of a sample can be believed.
#pragma once

#include <array>

#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/rest_values.h"

namespace palpate {

struct SignalFlaws {
  bool finite = true;      // false: nothing can be said
  bool saturated = false;  // an electrode reads the end of its 12 bits
  std::array<bool, kElectrodeCount> dead{};
  bool any_dead = false;
  [[nodiscard]] bool any() const { return saturated || any_dead; }
};

class SignalCheck {
 public:
  // `threshold`: change of an active electrode [counts].
  SignalCheck(const ElectrodeLayout& layout, double threshold);

  // An electrode is taken for dead that reads its rest value to the last digit while the two
  // nearest to it have moved by four thresholds and most others at all. Where readings and rest are
  // whole counts, an electrode that passes its rest value looks the same for a sample: 2 % of the
  // samples of presses on a plate. Allocation-free.
  [[nodiscard]] SignalFlaws Check(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept;

 private:
  std::array<std::array<int, 2>, kElectrodeCount> nearest_{};
  double moved_;  // [counts]
};

}  // namespace palpate
