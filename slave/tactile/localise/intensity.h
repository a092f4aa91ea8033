// What a contact does to each electrode, once that which all have in common is taken away.
#pragma once

#include <array>
#include <cstddef>

#include "slave/tactile/localise/signal_check.h"
#include "slave/tactile/rest_values.h"

namespace palpate {

// A contact raises the fluid's pressure, and the electrodes that are not under it rise in
// proportion. So a change is read against what the pressure alone explains,
//
//   x_i = change_i - kPressureShare change_pdc,
//
// and even a soft contact, under which hardly an electrode falls, shows where they rise least. The
// share is between the best for presses on a plate (0.10) and for others of that sensor
// (0.15); on the authors' soft recording, another sensor, the electrodes' mean is 0.17.
inline constexpr double kPressureShare = 0.13;  // [counts / count]

struct Intensities {
  std::array<double, kElectrodeCount> of{};  // 0: not active
  double total = 0;
  int active = 0;

  void Set(std::size_t electrode, double intensity) noexcept {
    of[electrode] = intensity;
    total += intensity;
    ++active;
  }
};

// Active: x_i < -threshold; intensity |x_i| [counts]. What is dead is left out, here and below.
Intensities PressureWeighted(const TactileSignals& change, const SignalFlaws& flaws,
                             double threshold) noexcept;

// Active: |x_i| > threshold, whichever way they moved; intensity (|x_i| / (2 full_scale))^2, at
// most 1. The square keeps the many that rise a little from outvoting the few that fall a lot.
Intensities PolarityFree(const TactileSignals& change, const SignalFlaws& flaws, double threshold,
                         double full_scale) noexcept;

}  // namespace palpate
