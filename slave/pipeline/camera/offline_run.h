// The pipeline over recorded pictures, or over a simulated site's scripted press, as fast as it
// goes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "slave/pipeline/camera/estimator.h"
#include "slave/pipeline/offline/error_budget.h"
#include "slave/pipeline/offline/run_summary.h"
#include "slave/scene/scene.h"

namespace palpate {

// What a run came to.
struct OfflineSummary : RunSummary {
  StageHistograms times;
  ErrorBudget budget;  // empty unless the site is simulated
  Registration registration;
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
