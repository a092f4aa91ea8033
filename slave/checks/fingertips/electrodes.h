// Electrodes work and match each other, now and in the network's window. Samples do not repeat.
#pragma once

#include <algorithm>
#include <cmath>

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class ElectrodesCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    const Fingertip& tip = sample.tip;
    const StuckElectrodes& stuck = tip.stuck();
    const auto fail = [&](bool is_so, FailedCheck check, std::string_view why) {
      if (is_so) findings->Fail(check, why);
    };
    fail(tip.touch().place.is_flawed, FailedCheck::kElectrode, "electrodes are saturated or dead");
    fail(stuck.are_frozen() || stuck.are_all(), FailedCheck::kFrozen,
         "all channels are constant: the sensor is dead or its driver repeats samples");
    fail(stuck.count() > 0 && !tip.signals(), FailedCheck::kElectrode,
         "an electrode or channel is constant: it is dead");
    fail(tip.holds_flaw(), FailedCheck::kElectrode, "a faulty sample in the window");
    if (!tip.signals() || tip.misses()) return;
    // d^2 / n of n signals has the mean 1 and the variance 2 / n.
    sample.consistency->Add({FailedCheck::kElectrode, "the electrodes do not match each other",
                             std::max(0.0, tip.signals()->mahalanobis2() - 1),
                             std::sqrt(2.0 / kPatternSignals)});
  }
};

}  // namespace palpate
