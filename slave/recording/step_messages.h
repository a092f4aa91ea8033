// Converts inputs and outputs of the sensing to and from messages, with all digits.
#pragma once

#include <string>

#include "palpate/v1/recording.pb.h"

#include "shared/state/slave_state.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

void ToProto(const Eigen::Vector3d& vector, v1::Exact3* message);
inline Eigen::Vector3d FromProto(const v1::Exact3& message) {
  return {message.x(), message.y(), message.z()};
}

// Overwrites `message`. The bytes are equal if and only if the estimates are equal.
void ToProto(const ContactEstimate& felt, v1::FeltState* message);
void ToProto(const TactileFrame& frame, v1::TactileInstant* message);
// Throws InputError: more fingertips than there may be, fewer electrodes or numbers of a pose, a
// number that is not finite.
TactileFrame FromProto(const v1::TactileInstant& message);

void ToProto(const Scene& scene, v1::SenseStep::Settings* message);

// [ns since 1970]. Throws InputError: no time of ours.
Time StampFrom(std::uint64_t ns);

}  // namespace palpate
