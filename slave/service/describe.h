// What the slave says of itself, as messages.
#pragma once

#include "palpate/v1/scene.pb.h"
#include "palpate/v1/state.pb.h"
#include "palpate/v1/telemetry.pb.h"

#include "slave/pipeline/teleop/slave.h"

namespace palpate {

void ToProto(const SlaveDescription& description, v1::SceneDescription* message);
void ToProto(const SlaveDescription& description, v1::Capabilities* message);
// Fills what the slave knows; the service adds operator, observers and what it sent and refused.
void ToProto(const SlaveStatus& status, v1::Status* message);
// `with_topology`: elements and rest positions too, for the first message of a stream.
void ToProto(const BoundaryShape& shape, bool with_topology, v1::MeshState* message);
// Takes the picture's bytes.
void ToProto(JpegPicture picture, std::uint64_t sequence, v1::VideoFrame* message);

// The geometry in words and millimetres, for people.
std::string Describe(const Geometry& geometry);

}  // namespace palpate
