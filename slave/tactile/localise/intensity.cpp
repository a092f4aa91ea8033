#include "slave/tactile/localise/intensity.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// x_i.
double BeyondPressure(const TactileSignals& change, std::size_t electrode) noexcept {
  const double pressure = static_cast<double>(change[kElectrodeCount + 1]);
  return static_cast<double>(change[electrode]) - kPressureShare * pressure;
}

}  // namespace

Intensities PressureWeighted(const TactileSignals& change, const SignalFlaws& flaws,
                             double threshold) noexcept {
  Intensities intensities;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const double fall = -BeyondPressure(change, i);
    if (fall > threshold && !flaws.dead[i]) intensities.Set(i, fall);
  }
  return intensities;
}

Intensities PolarityFree(const TactileSignals& change, const SignalFlaws& flaws, double threshold,
                         double full_scale) noexcept {
  Intensities intensities;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const double moved = std::abs(BeyondPressure(change, i));
    const double share = std::min(moved / (2 * full_scale), 1.0);
    if (moved > threshold && !flaws.dead[i]) intensities.Set(i, share * share);
  }
  return intensities;
}

}  // namespace palpate
