// Whether the manipulator's encoders can be compared with the images, and at which time.
#pragma once

#include <optional>

#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

// Time between encoder reading and image [image periods], `replayed` if the reading is of the
// image's own time; nullopt: recorded images do not show the manipulator. For a live one the
// reading is taken at the arrival of the image, after its capture.
inline std::optional<double> ArmLag(const Pace& pace, double replayed) {
  constexpr double kLive = 1.5;  // [-] [tuned: APressIntoItIsEstimatedAsDeepAsItIs]
  if (!pace.p_S_tip) return std::nullopt;
  return pace.is_live ? kLive : replayed;
}

}  // namespace palpate
