// The pipeline over recorded pictures, or over a simulated site's scripted press, as fast as it
// goes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <stop_token>
#include <string>

#include "shared/scene/scene.h"
#include "slave/pipeline/error_budget.h"
#include "slave/pipeline/estimator.h"

namespace palpate {

// What a run came to.
struct OfflineSummary {
  std::uint64_t frames = 0;
  double seconds = 0;  // wall clock, without the model's precompute [s]
  std::uint64_t tracking_lost = 0;
  std::map<std::string, std::uint64_t> validity;  // pictures per validity
  StageHistograms times;
  LatencyHistogram capture;
  ErrorBudget budget;  // empty unless the site is simulated
  bool has_truth = false;
  Registration registration;
  ModelInfo model;
};

struct OfflineOptions {
  std::filesystem::path out;  // made if missing; gets states.csv and summary.json
  bool pictures = false;      // also out/pictures/NNNNNN.jpg with what was seen drawn in
  bool frames = false;        // also out/frames/NNNNNN.png as they came, without loss
  std::function<void(std::uint64_t)> progress;  // called with the pictures done; may be empty
};

// Runs until the source ends or `stop`. Rows of states.csv are flushed one by one, so that it stays
// readable whatever happens; at a simulated site they end with the true force. Where the force is
// unknown, its columns and sigma are empty. Throws std::runtime_error: source unusable or a picture
// in it, out not writable.
OfflineSummary RunOffline(const Scene& scene, const OfflineOptions& options,
                          const std::stop_token& stop);

}  // namespace palpate
