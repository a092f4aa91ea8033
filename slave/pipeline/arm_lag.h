// Whether a manipulator is a witness of what pictures show, and of which instant.
#pragma once

#include <optional>

#include "slave/pipeline/sensing_pipeline.h"

namespace palpate {

// How far the arm's word may be from the picture [their periods], `replayed` where it is asked for
// the picture's own instant; nullopt: a recorded tool's
// pictures do not show the arm that moves here. A live one is asked when the picture has come, a
// while after it was taken.
inline std::optional<double> ArmLag(const Pace& pace, const SimulatedEnvironment* environment,
                                    double replayed) {
  constexpr double kLive = 1.5;
  if (environment == nullptr && !pace.p_S_tip) return std::nullopt;
  return pace.is_live ? kLive : replayed;
}

}  // namespace palpate
