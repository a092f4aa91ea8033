// A slave's recording made anew: the sense of its scene is given the same samples and asked the
// same in the same order, and what it feels is held against what was felt.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

// How far states felt anew are from those recorded.
struct StateDifferences {
  std::uint64_t states = 0;     // compared
  std::uint64_t different = 0;  // of them, in any digit
  std::uint64_t first = 0;      // sample of the first that differs; 0: none does
  double force = 0;             // the largest of the force's vector [N]
  double tip = 0;               // of the tip's place [m]
  std::uint64_t validity = 0;   // states whose validity, or whether a force is known, differs
};

struct RecordedRun {
  StateDifferences differences;
  std::string version, version_now;  // of the program that recorded, and of this one
  std::string damage;  // what of the recording cannot be read, in words; empty: nothing
  std::string scene;   // its name
};

// Writes out/states.csv, as RunOffline does, of what is felt now, out/summary.json, and the scene's
// files below out/scene. `progress`: called with the states done; may be empty. Throws InputError
// or std::runtime_error: no slave's recording, damaged, out not writable; SceneError: its scene
// cannot be read here.
RecordedRun ProcessRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                             const std::stop_token& stop,
                             const std::function<void(std::uint64_t)>& progress = {});

// The summary in words, a line each.
std::vector<std::string> InWords(const RecordedRun& run);

}  // namespace palpate
