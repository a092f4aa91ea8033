// `palpate-slave process`: runs the pipeline on recorded sources as fast as possible.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

struct ProcessOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::filesystem::path out;
  bool images = false;             // also write images with the detections drawn in
  bool frames = false;             // also write the source images
  bool points = false;             // also write the points that are followed
  std::optional<double> duration;  // of a simulated target's path [s]
};

// Writes out/states.csv and out/summary.json, and prints a summary. 0: done. Throws SceneError and
// std::exception. If `scene` is a recording (FILE.mcap), its states are recomputed and compared
// with the recorded ones.
int RunProcess(const ProcessOptions& options, const std::stop_token& stop);

}  // namespace palpate
