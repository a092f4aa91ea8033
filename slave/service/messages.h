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

#include "slave/capture/image_inbox.h"
#include "slave/capture/tactile_frame.h"
#include "slave/live/driver_messages.h"
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

void ToProto(const ArmHealth& health, v1::ArmStatus* message);
void ToProto(const CameraHealth& health, v1::CameraStatus* message);
void ToProto(const ArmAim& aim, Time now, v1::ArmTarget* message);

void ToProto(const SlaveDescription& description, v1::SceneDescription* message);
// Fills the slave's fields; the service adds operator, observers and its own counts.
void ToProto(const SlaveStatus& status, v1::Status* message);
// `with_topology`: elements and rest positions too, for the first message of a stream.
void ToProto(const BoundaryShape& shape, bool with_topology, v1::MeshState* message);
// Moves the image's bytes into the message.
void ToProto(EncodedImage image, std::uint64_t sequence, v1::ImageState* message);

}  // namespace palpate
