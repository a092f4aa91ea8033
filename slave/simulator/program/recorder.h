// Writes the samples of a scripted press to files, as fast as they are computed.
#pragma once

#include <filesystem>
#include <stop_token>

#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

// Files in `folder`, which depend only on the scene and its seed; the k-th messages of the first
// two belong to one instant. Messages are preceded by their size as a varint.
//   pictures.pb   palpate.v1.PictureSample, of scenes with cameras
//   tactile.pb    palpate.v1.TactileSample, of scenes with fingertips, one per fingertip and
//   instant arm.pb        palpate.v1.ArmReport, one per instant, with the true force where it is
//   solved truth.csv     true state of the tool, or of each fingertip: lengths [m], force [N],
//   frame S
// Throws std::runtime_error: a file cannot be written. `duration`: of a target that moves on a path
// [s]; 0: its own.
void Record(const Scene& scene, SimulatedEnvironment& environment,
            const std::filesystem::path& folder, double duration, const std::stop_token& stop);

}  // namespace palpate
