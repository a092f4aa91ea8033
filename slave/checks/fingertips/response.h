// Fingertip and force are as those of the network's training.
#pragma once

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class ResponseCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    const FingerTouch& touch = sample.tip.touch();
    const NetworkInfo& network = sample.tip.network();
    const double force = touch.force_F ? touch.force_F->norm() : 0;
    if (network.learnt_force > 0 && force > network.learnt_force) {
      findings->Fail(FailedCheck::kModelRange,
                     "the force is beyond the training range of the network");
    }
    const auto fail = [&](bool is_so, std::string_view why) {
      if (is_so) findings->Fail(FailedCheck::kTransfer, why);
    };
    fail(!touch.touching && !touch.place.usable() && force > kUnseenTouch * network.sigma.norm(),
         "there is a force, but no contact point");
    const SignalModel* model = sample.tip.signals();
    if (model == nullptr || sample.tip.misses()) return;
    fail(model->noise().since_start() < kFallen,
         "the noise of the electrodes is lower than at the start: their gain has fallen");
    fail(model->noise().relative() < kQuietest,
         "the noise of the electrodes is lower than in the training data: their gain is lower");
    sample.consistency->Add({FailedCheck::kTransfer, "the pressure does not match the electrodes",
                             model->pressure_residual(), kPressureSigma});
  }

 private:
  // Pressure minus expectation, over its standard deviation in the model, which holds for contacts
  // of all kinds: what a single contact is off by persists [-]. [tuned: pressure stuck]
  static constexpr double kPressureSigma = 1.3;
  // Noise of the electrodes by that at the start; real fingers in a minute: 0.95 to 1.1 [-].
  static constexpr double kFallen = 0.85;
  // The same by that of the training; five real fingers: 0.83 to 1.17 [-]. [tuned: gain of all
  // wrong]
  static constexpr double kQuietest = 0.8;
  // Force without an active electrode, by the error of the network [sigma].
  static constexpr double kUnseenTouch = 3;
};

}  // namespace palpate
