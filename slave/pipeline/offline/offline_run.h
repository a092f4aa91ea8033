// A sense over recorded samples, or over a simulated site's script, as fast as it goes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "slave/pipeline/offline/offline_report.h"
#include "slave/scene/scene.h"

namespace palpate {

struct OfflineOptions {
  std::filesystem::path out;  // made if missing; gets states.csv and summary.json
  bool pictures = false;      // also out/pictures/NNNNNN.jpg with what was seen drawn in
  bool frames = false;        // also out/frames with the pictures as they came, without loss
  std::function<void(std::uint64_t)> progress = {};  // called with the samples done; may be empty
  double duration = 0;  // of a simulated target's path [s]; 0: its own choice
  bool points = false;  // also out/points.csv with each followed point of each sample
};

// Runs until the source ends or `stop`. Rows of states.csv are flushed one by one, so that it stays
// readable whatever happens; at a simulated site they end with the true force. Where the force is
// unknown, its columns and sigma are empty; so are places that nobody knows. Throws
// std::runtime_error: source unusable or a sample in it, out not writable, too few samples for the
// rest values; std::invalid_argument: what cannot be modelled, a source without an end, a
// `duration` of what ends by itself.
OfflineSummary RunOffline(const Scene& scene, const OfflineOptions& options,
                          const std::stop_token& stop);

}  // namespace palpate
