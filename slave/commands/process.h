// `palpate-slave process`: the pipeline over recorded sources as fast as they go.
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
  bool pictures = false;           // also write pictures with what was seen drawn in
  bool frames = false;             // also write pictures as they came
  std::optional<double> duration;  // of a simulated target's path [s]
};

// Writes out/states.csv and out/summary.json, prints a summary for people. 0: done. Throws
// SceneError and std::exception.
int RunProcess(const ProcessOptions& options, const std::stop_token& stop);

}  // namespace palpate
