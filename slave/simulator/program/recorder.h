// Writes the samples of a scripted press, as fast as they are computed.
#pragma once

#include <filesystem>
#include <stop_token>

#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

struct RecordOptions {
  std::filesystem::path folder;
  double duration = 0;   // of a target that moves on a path [s]; 0: its own
  int presses = 1;       // scripted contacts of fingertips
  bool surface = false;  // also records the true surface of the object that fingertips touch
};

// Writes `samples.pb` in `folder`, or to the standard output if that is `-`: one
// palpate.v1.SimulatedSample per instant, each preceded by its size as a varint. The bytes depend
// only on the scene and its seed. Throws std::invalid_argument: a duration without a target that
// moves on a path; std::runtime_error: the file cannot be written.
void Record(const Scene& scene, SimulatedEnvironment& environment, const RecordOptions& options,
            const std::stop_token& stop);

}  // namespace palpate
