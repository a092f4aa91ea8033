// Electrodes work and match each other, now and in the network's window. Samples do not repeat.
#pragma once

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
    fail(stuck.are_frozen() || stuck.count() == kElectrodeCount, FailedCheck::kFrozen,
         "all electrodes are constant: the sensor is dead or its driver repeats samples");
    fail(stuck.count() > 0 && !tip.pattern(), FailedCheck::kElectrode,
         "an electrode is constant: it is dead");
    fail(tip.baseline().steps() > kManySteps, FailedCheck::kElectrode,
         "all electrodes step together repeatedly");
    fail(tip.pattern() && tip.pattern()->misfit() > kMisfit, FailedCheck::kElectrode,
         "the electrodes do not match each other");
    fail(tip.holds_flaw(), FailedCheck::kElectrode, "a faulty sample in the window");
  }

 private:
  // Steps of all electrodes together, in about 30 samples [-].
  static constexpr double kManySteps = 2.5;
  // Residual of the electrodes by its usual mean [-]. [tuned: plugged in one off]
  static constexpr double kMisfit = 1.6;
};

}  // namespace palpate
