// Time between the manipulator's encoders and the samples of a sensing.
#pragma once

namespace palpate {

// One standard deviation [sample periods]. The timestamp of a sample may lack a driver's latency.
inline constexpr double kArmLag = 1.5;  // [tuned: APressIntoAMovingObjectHasTheRightDepth]

}  // namespace palpate
