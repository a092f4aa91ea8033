// Watches the contact's model beside the states: a stream and a thread of its own. A slave that
// makes none, or is too old to, leaves the plane of the states.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "shared/link/latest_value.h"
#include "shared/state/surface_patch.h"

namespace palpate {

// A patch as it was received, whole.
struct ReceivedPatch {
  SurfacePatch patch;  // its epoch rises from stream to stream, too
  PatchLaw law;        // the newest of it
};

class PatchWatch {
 public:
  struct Options {
    std::string target;         // HOST:PORT
    bool insecure = false;      // allow targets that are not loopback, in plain text
    std::filesystem::path tls;  // the folder of our certificate; empty: plain text
    std::chrono::milliseconds longest_round_trip{1000};  // beyond it the line is dead
  };
  struct Stats {
    std::uint64_t patches = 0, laws = 0, refused = 0;  // refused: with impossible numbers
    std::uint64_t bytes = 0;                           // of all that came
    std::string trouble;  // why none comes at the moment, or why the last was refused
  };

  // Opens the stream and keeps it open, reconnecting with back-off; `patches` outlives the watch.
  // Throws std::invalid_argument: target not understood, or not loopback without `insecure`.
  PatchWatch(const Options& options, LatestValue<ReceivedPatch>* patches);
  ~PatchWatch();
  [[nodiscard]] Stats stats() const;  // thread-safe
  void Stop();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
