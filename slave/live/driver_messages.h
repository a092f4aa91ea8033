// Converts the messages of drivers (devices.proto of palpate.v1).
#pragma once

#include <optional>
#include <string>

#include "palpate/v1/devices.pb.h"
#include "palpate/v1/state.pb.h"

#include "slave/capture/image_inbox.h"
#include "slave/capture/tactile_frame.h"
#include "slave/manipulator/driven_arm.h"

namespace palpate {

// palpate.v1.TactileSample -> FingerReading.
struct TactileSample {
  Time sensed_at{};  // sender's clock
  FingerReading reading;
};

// nullopt: no channel or more than 256, more than two pressures, no timestamp, an incomplete or
// invalid pose; `reason` states which and what is accepted. The caller checks whether counts are
// finite.
std::optional<TactileSample> FromProto(const v1::TactileSample& message, std::string* reason);

// nullopt: no timestamp, or an unknown encoding; `reason` states which and what is accepted. The
// result points into `message`.
std::optional<PushedSample> FromProto(const v1::ImageSample& message, std::string* reason);
// nullopt: numbers that are not finite or too large, no timestamp, no tip, an incomplete
// quaternion; `reason` states which and what is accepted.
std::optional<ArmReading> FromProto(const v1::ArmReport& message, std::string* reason);

}  // namespace palpate
