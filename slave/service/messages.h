// Conversions between messages of palpate.v1 and the slave's types, with checks of all requests and
// inputs.
#pragma once

#include <optional>
#include <string>

#include "palpate/v1/devices.pb.h"
#include "palpate/v1/scene.pb.h"
#include "palpate/v1/state.pb.h"
#include "palpate/v1/telemetry.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "slave/capture/picture_inbox.h"
#include "slave/capture/tactile_frame.h"
#include "slave/live/slave.h"
#include "slave/manipulator/driven_arm.h"

namespace palpate {

// Requests are checked as documented in teleoperation.proto. All throw std::invalid_argument:
// `field = value: expected ...`.

// The shortest time between two messages of a stream: zero for 0, each new state.
Clock::duration GapOf(const v1::WatchStateRequest& request);
// 0 means 30 Hz.
Clock::duration GapOf(const v1::WatchMeshRequest& request);
Clock::duration GapOf(const v1::WatchImagesRequest& request);
// 0 means 10 Hz.
Clock::duration GapOf(const v1::WatchTraceRequest& request);
// JPEG quality, 0 means 80.
int QualityOf(const v1::WatchImagesRequest& request);

ParameterChange ToChange(const v1::SetParametersRequest& request);
ModelChange ToChange(const v1::SetModelRequest& request);

// palpate.v1.TactileSample -> FingerReading.
struct TactileSample {
  Time sensed_at{};  // sender's clock
  FingerReading reading;
};

// nullopt: not 1 to 256 channels or more than two pressures, no timestamp, an incomplete or invalid
// pose; `reason` states which and what is accepted. The caller checks whether counts are finite.
std::optional<TactileSample> FromProto(const v1::TactileSample& message, std::string* reason);

// nullopt: no timestamp, or an unknown encoding; `reason` states which and what is accepted. The
// result points into `message`.
std::optional<PushedSample> FromProto(const v1::ImageSample& message, std::string* reason);
// nullopt: numbers that are not finite or too large, no timestamp, no tip, an incomplete
// quaternion; `reason` states which and what is accepted.
std::optional<ArmReading> FromProto(const v1::ArmReport& message, std::string* reason);
void ToProto(const ArmHealth& health, v1::ArmStatus* message);
void ToProto(const CameraHealth& health, v1::CameraStatus* message);
void ToProto(const ArmAim& aim, Time now, v1::ArmTarget* message);

void ToProto(const SlaveDescription& description, v1::SceneDescription* message);
// Fills the slave's fields; the service adds operator, observers and its own counts.
void ToProto(const SlaveStatus& status, v1::Status* message);
// `with_topology`: elements and rest positions too, for the first message of a stream.
void ToProto(const BoundaryShape& shape, bool with_topology, v1::MeshState* message);
// Moves the image's bytes into the message.
void ToProto(JpegPicture picture, std::uint64_t sequence, v1::ImageState* message);

}  // namespace palpate
