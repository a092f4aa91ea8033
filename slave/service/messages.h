// Messages of palpate.v1 and the slave's own types: what the slave is asked and fed, checked, and
// what it says of itself.
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
#include "slave/manipulator/driven_arm.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Requests are checked exactly as the comments of teleoperation.proto say. All throw
// std::invalid_argument: `field = value: accepted is ...`.

// The shortest time between two messages of a stream: zero for 0, each new state.
Clock::duration GapOf(const v1::WatchStateRequest& request);
// 0 stands for 30 Hz.
Clock::duration GapOf(const v1::WatchMeshRequest& request);
Clock::duration GapOf(const v1::WatchVideoRequest& request);
// 0 stands for 10 Hz.
Clock::duration GapOf(const v1::WatchTraceRequest& request);
// JPEG quality, 0 stands for 80.
int QualityOf(const v1::WatchVideoRequest& request);

ParameterChange ToChange(const v1::SetParametersRequest& request);
ModelChange ToChange(const v1::SetModelRequest& request);

// palpate.v1.TactileSample -> FingerReading.
struct TactileSample {
  Time sensed_at{};  // sender's clock
  FingerReading reading;
};

// nullopt: another number of electrodes than 19 or of pressures than at most two, no stamp, half a
// pose or none that is one; `reason` then says which and what is accepted. Whether counts are
// finite is left to whoever takes them.
std::optional<TactileSample> FromProto(const v1::TactileSample& message, std::string* reason);

// nullopt: no stamp or an encoding not known; `reason` then says which and what is accepted. What
// it returns points into `message`.
std::optional<PushedSample> FromProto(const v1::PictureSample& message, std::string* reason);
// nullopt: numbers that are none or absurd, no stamp, no tip, half a quaternion; `reason` then says
// which and what is accepted.
std::optional<ArmReading> FromProto(const v1::ArmReport& message, std::string* reason);
void ToProto(const ArmHealth& health, v1::ArmStatus* message);
void ToProto(const CameraHealth& health, v1::CameraStatus* message);
void ToProto(const ArmAim& aim, Time now, v1::ArmTarget* message);

void ToProto(const SlaveDescription& description, v1::SceneDescription* message);
void ToProto(const SlaveDescription& description, v1::Capabilities* message);
// Fills what the slave knows; the service adds operator, observers and what it sent and refused.
void ToProto(const SlaveStatus& status, v1::Status* message);
// `with_topology`: elements and rest positions too, for the first message of a stream.
void ToProto(const BoundaryShape& shape, bool with_topology, v1::MeshState* message);
// Takes the picture's bytes.
void ToProto(JpegPicture picture, std::uint64_t sequence, v1::VideoFrame* message);

}  // namespace palpate
