// Samples of the simulator as messages of the driver protocol.
#pragma once

#include <vector>

#include "palpate/v1/devices.pb.h"
#include "palpate/v1/simulation.pb.h"
#include "palpate/v1/state.pb.h"

#include "slave/capture/frame_source.h"
#include "slave/capture/ground_truth.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

// Times are those of the samples. Images are sent as pixels, without loss.
v1::ImageSample ToMessage(const Frame& frame);
v1::ImageSample ToMessage(const StereoPair& pair);
// One message per fingertip of `frame`, named after `fingers`.
std::vector<v1::TactileSample> ToMessages(const TactileFrame& frame,
                                          const std::vector<Finger>& fingers);
// The true state of `scene` at the last sample, without the surface.
void PutTruth(const GroundTruth& truth, const Scene& scene, v1::SimulatedTruth* message);
void PutSurface(const SurfaceMesh& surface, bool with_triangles, v1::SimulatedTruth* message);

}  // namespace palpate
