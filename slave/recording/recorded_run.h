// Recomputes a slave's recording: the sensing of its scene gets the same samples and queries in the
// same order, and its estimates are compared with the recorded ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

// Differences of recomputed states from recorded ones.
struct StateDifferences {
  std::uint64_t states = 0;     // number of compared states
  std::uint64_t different = 0;  // number of states that differ in any digit
  std::uint64_t first = 0;      // sample of the first that differs; 0: none does
  double force = 0;             // largest difference of the force vector [N]
  double tip = 0;               // difference of the tip position [m]
  // Number of states that differ in validity, or in whether a force is known.
  std::uint64_t validity = 0;
};

struct RecordedRun {
  StateDifferences differences;
  std::string version, version_now;  // of the program that recorded, and of this one
  std::string damage;                // unreadable parts of the recording, as text; empty: none
  std::string scene;                 // name of the scene
};

// Writes the recomputed out/states.csv, as RunOffline does, out/summary.json, and the scene's files
// below out/scene. `progress`: called with the number of finished states; may be empty. Throws
// InputError or std::runtime_error: not a slave's recording, damaged, out not writable; SceneError:
// its scene cannot be read here.
RecordedRun ProcessRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                             const std::stop_token& stop,
                             const std::function<void(std::uint64_t)>& progress = {});

// The summary as text, one line each.
std::vector<std::string> InWords(const RecordedRun& run);

}  // namespace palpate
