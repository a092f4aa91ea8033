// The force is that of the object at this depth, as far as its model is known.
#pragma once

#include <cmath>

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class ModelForceCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* /*findings*/) noexcept override {
    if (!sample.force_ratio || !(*sample.force_ratio > 0)) return;
    sample.consistency->Add(
        {FailedCheck::kTransfer, "the force does not match that of the model at this depth",
         std::log(*sample.force_ratio), std::hypot(kModelSigma, sample.force_ratio_sigma)});
  }

 private:
  // Logarithm of a force over that of a model of small strain [-]. [tuned: object softer than
  // stated]
  static constexpr double kModelSigma = 0.25;
};

}  // namespace palpate
