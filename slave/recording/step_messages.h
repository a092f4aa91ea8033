// Converts inputs of the sensing to and from messages, with all digits, and its estimates.
#pragma once

#include <string>

#include "palpate/v1/recording.pb.h"

#include "shared/state/slave_state.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

// Overwrites state and sample number of the message, but not `p_S_arm`.
void ToProto(const ContactEstimate& estimate, v1::SenseStep::Estimate* message);
void ToProto(const TactileFrame& frame, v1::TactileInstant* message);
// Throws InputError: more fingertips than there may be, fewer electrodes or numbers of a pose, a
// number that is not finite.
TactileFrame FromProto(const v1::TactileInstant& message);

void ToProto(const Scene& scene, v1::SenseStep::Settings* message);

// Throw InputError: not finite, or out of range.
Eigen::Vector3d RecordedPosition(const v1::Vec3& message);
Time RecordedTime(const google::protobuf::Timestamp& message);

}  // namespace palpate
