// The force is that of the object at this depth, as far as its model is known.
#pragma once

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class ModelForceCheck final : public Check<ContactSample> {
 public:
  void Examine(const ContactSample& sample, Findings* findings) noexcept override {
    if (!sample.press) return;
    const auto& [depth, force, sigma, least, greatest] = *sample.press;
    const bool is_deep = depth > kDeep;
    if (force + sigma > (is_deep ? kLeastDeep : kLeastShallow) * least &&
        force - sigma < (is_deep ? kMostDeep : kMostShallow) * greatest) {
      return;
    }
    findings->Fail(FailedCheck::kTransfer,
                   "the force does not match that of the model at this depth");
  }

 private:
  // Depth by that of the scene's press, from which on the closer limits hold [-]. [tuned:
  // AForceFarFromThatOfTheModelIsFlagged]
  static constexpr double kDeep = 0.6;
  // Force by that of the model, which is off by tens of percent [-]. [tuned: object softer than
  // told]
  static constexpr double kLeastDeep = 0.65, kMostDeep = 1.5;
  // The same where the model is off by more [-]. [tuned: object softer than told]
  static constexpr double kLeastShallow = 0.35, kMostShallow = 1.8;
};

}  // namespace palpate
