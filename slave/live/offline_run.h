// Runs a slave on recorded samples, or on a simulator's script, as fast as possible.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "slave/pipeline/offline/offline_report.h"
#include "slave/scene/scene.h"

namespace palpate {

struct OfflineOptions {
  std::filesystem::path out;  // created if missing; gets states.csv and summary.json
  bool images = false;        // also out/images/NNNNNN.jpg with the detections drawn in
  bool frames = false;        // also out/frames with the source images, without loss
  std::function<void(std::uint64_t)> progress = {};  // called with the samples done; may be empty
  double duration = 0;  // duration of a simulated target's path [s]; 0: its default
  bool points = false;  // also out/points.csv with each followed point of each sample
};

// Runs until the source ends or `stop`. Rows of states.csv are flushed one by one, so that it is
// always readable; with a simulator they end with the true force. If the force is unknown, its
// columns and sigma are empty, as are unknown positions. Throws std::runtime_error: source unusable
// or a sample in it, out not writable, too few samples for the baseline; std::invalid_argument: a
// scene that cannot be modelled, a source without an end, a `duration` for a source that ends on
// its own.
//
// It is the slave of `serve` on a driven clock: images and fingertips of a simulated scene arrive
// as messages of its drivers, and so do the positions of its manipulator. The digits are equal in
// each run.
OfflineSummary RunOffline(const Scene& scene, const OfflineOptions& options,
                          const std::stop_token& stop);

}  // namespace palpate
