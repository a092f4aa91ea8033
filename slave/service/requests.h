// Requests, checked exactly as the comments of teleoperation.proto say. All throw
// std::invalid_argument: `field = value: accepted is ...`.
#pragma once

#include "palpate/v1/teleoperation.pb.h"

#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// The shortest time between two messages of a stream: zero for 0, each new state.
Clock::duration GapOf(const v1::WatchStateRequest& request);
// 0 stands for 30 Hz.
Clock::duration GapOf(const v1::WatchMeshRequest& request);
Clock::duration GapOf(const v1::WatchVideoRequest& request);
// JPEG quality, 0 stands for 80.
int QualityOf(const v1::WatchVideoRequest& request);

ParameterChange ToChange(const v1::SetParametersRequest& request);
ModelChange ToChange(const v1::SetModelRequest& request);

}  // namespace palpate
