// Checks that the surface is indented at the position and depth that the encoders report for the
// tip. Images of another instant pass all checks of images alone.
#pragma once

#include <utility>

#include "slave/checks/load/load_sample.h"

namespace palpate {

class EncoderDepthCheck final : public Check<LoadSample> {
 public:
  // Distance from the tip above which a load belongs to another tool, relative to the larger side
  // [-]. [tuned: surface_flags_test, an indentation that is not under the tip]
  static constexpr double kNear = 0.1;

  // Ignores a load that is not under the tip, because another body causes it. A pressing tip must
  // have a load.
  void Examine(const LoadSample& sample, Findings* findings) noexcept override;
  void Reset() noexcept override { distrust_ = 0; }

 private:
  double last_depth_ = 0;  // of the tip [m]
  int distrust_ = 0;       // images until cameras and encoders are trusted again
};

}  // namespace palpate
