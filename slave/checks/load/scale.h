// An error of all distances is an error of the force.
#pragma once

#include "slave/checks/load/load_sample.h"

namespace palpate {

class ScaleCheck final : public Check<LoadSample> {
 public:
  void Examine(const LoadSample& sample, Findings* findings) noexcept override {
    findings->Widen(kForceOfScale * sample.seen.scale_error * sample.load.force);
  }

 private:
  // Relative error of the force by that of the distances [-]. [derived: the force of a stretched
  // membrane goes with the third power of the depth, and the depth of a camera that has turned with
  // the square of the distance]
  static constexpr double kForceOfScale = 6;
};

}  // namespace palpate
