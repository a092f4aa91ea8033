// Time between the manipulator's encoders and the samples of a sensing.
#pragma once

#include "slave/capture/pace.h"

namespace palpate {

// One standard deviation [sample periods]. The timestamp of a live sample may lack a driver's
// latency; `replayed`: of samples that are not live.
inline double ArmLag(const Pace& pace, double replayed) {
  constexpr double kLive = 1.5;  // [-] [tuned: APressIntoItIsEstimatedAsDeepAsItIs]
  return pace.is_live ? kLive : replayed;
}

}  // namespace palpate
