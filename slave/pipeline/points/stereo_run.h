// The eyes' pipeline over recorded pictures, or over a simulated site's scripted press or moving
// target, as fast as it goes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/pipeline/offline/error_budget.h"
#include "slave/pipeline/offline/run_summary.h"
#include "slave/pipeline/points/point_errors.h"
#include "slave/pipeline/points/press_steps.h"
#include "slave/scene/scene.h"

namespace palpate {

struct StereoSummary : RunSummary {
  std::string eyes;              // dots, texture or depth
  LatencyHistogram look, total;  // of the eyes; of eyes and mechanics
  LatencyHistogram mechanics;
  bool tells_force = false;
  std::map<std::string, std::uint64_t> reasons;  // why pairs are not `valid`
  std::size_t points = 0;                        // looked for
  std::size_t points_followed = 0;               // of them, seen at least once
  std::uint64_t points_unseen = 0;  // times one of those was not, after the rest frame was taken
  ErrorBudget budget;               // of the force, where the truth is known
  std::vector<PressStep> steps;     // of a simulated press
  ErrorOfPoints displacement;       // of a simulated membrane's points
  ErrorOfPoints place;              // of a simulated target's points
};

struct StereoRunOptions {
  std::filesystem::path out;  // made if missing; gets states.csv and summary.json
  bool pictures = false;      // also out/pictures/NNNNNN.jpg with what was seen drawn in
  // Also out/frames/left/NNNNNN.png and right, as they came, and rig.yaml beside them: a recording
  // to process again. Depth pictures: left alone.
  bool frames = false;
  std::function<void(std::uint64_t)> progress;  // called with the pairs done; may be empty
  double duration = 0;  // of a simulated target's path [s]; 0: MembraneScript's own
};

// Runs until the source ends or `stop`; one row of states.csv per pair. The tool's place is empty
// where no manipulator moves it. Throws std::runtime_error: source unusable or a picture in it, out
// not writable, pictures that are not the rig's, or of which the rest frame was never complete;
// std::invalid_argument: what cannot be modelled, a `duration` of what ends by itself.
StereoSummary RunStereo(const Scene& scene, const StereoRunOptions& options,
                        const std::stop_token& stop);

}  // namespace palpate
