// Samples of a simulated scene, computed by palpate-simulator as fast as they are read, with the
// true state at their instants.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>

#include <Eigen/Core>

#include "palpate/v1/simulation.pb.h"

#include "slave/capture/ground_truth.h"
#include "slave/capture/sample_tap.h"
#include "slave/scene/scene.h"

namespace palpate {

// Simulation provides the samples of a simulated scene, and the truth at the sample that was
// returned last. Before the first sample it provides the truth of the first one.
class Simulation : public SamplePlayer, public GroundTruth {
 public:
  // The next sample as its drivers send it, valid until the next call; null: the simulation has
  // ended, or `stop`.
  virtual const v1::SimulatedSample* Next(const std::stop_token& stop) = 0;
};

struct SimulationOptions {
  double duration = 0;   // of a target that moves on a path [s]; 0: its own
  int presses = 1;       // scripted contacts of fingertips
  bool surface = false;  // with the true surface
};

// Starts palpate-simulator from the folder of the running program, with the scene's file and
// overrides. It ends when the result is destroyed. Throws std::invalid_argument: the simulator
// rejects the scene; std::runtime_error: it is not installed, or failed. A source of the result
// throws as well if the simulator fails later.
std::unique_ptr<Simulation> StartSimulation(const Scene& scene, const SimulationOptions& options);

}  // namespace palpate
