// The tactile pipeline over a recording, or over a simulated site's scripted touch, as fast as it
// goes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/pipeline/offline/run_summary.h"
#include "slave/scene/scene.h"

namespace palpate {

// Errors over samples in which estimate or truth exceed 1 % of the true peak [N].
struct TouchError {
  std::uint64_t count = 0;   // samples of all fingertips
  double rms = 0, peak = 0;  // of the force's vector, estimate minus truth
  double true_peak = 0;      // largest true force
  double model_rms = 0;      // size of what the master would render at the true depth, the first's
};

struct TactileSummary : RunSummary {  // frames: samples; one row per sample and fingertip
  TactileTimes times;
  TouchError error;
  std::string network;  // in words; empty: none
  std::string localiser;
};

struct TactileRunOptions {
  std::filesystem::path out;                    // made if missing; gets states.csv and summary.json
  int presses = 1;                              // of a simulated site
  std::function<void(std::uint64_t)> progress;  // called with the samples done; may be empty
};

// Runs until the source ends or `stop`; one row of states.csv per sample and fingertip, see
// StatesFile. Where nobody says where a fingertip is its places are empty and its force is in frame
// F. Throws std::runtime_error: source unusable, out not writable; std::invalid_argument: a stream,
// which has no end.
TactileSummary RunTactile(const Scene& scene, const TactileRunOptions& options,
                          const std::stop_token& stop);

}  // namespace palpate
