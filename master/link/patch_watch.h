// Receives the local contact model on a separate stream and thread. Without it the master uses the
// plane of the states.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "master/link/slave_link.h"
#include "shared/link/latest_value.h"
#include "shared/state/surface_patch.h"

namespace palpate {

// A complete received patch.
struct ReceivedPatch {
  SurfacePatch patch;  // its epoch rises also from stream to stream
  PatchLaw law;        // its newest force-depth curve
};

class PatchWatch {
 public:
  struct Stats {
    std::uint64_t patches = 0, laws = 0, refused = 0;  // refused: rejected as invalid
    std::uint64_t bytes = 0;                           // of all received messages
    std::string trouble;  // why none arrives, or why the last was rejected
  };

  // Opens the stream and keeps it open, reconnecting with back-off. `patches` must outlive this
  // object. Throws std::invalid_argument for an invalid target, or one beyond loopback without
  // `insecure`.
  PatchWatch(const SlaveLink::Options& link, LatestValue<ReceivedPatch>* patches);
  ~PatchWatch();
  [[nodiscard]] Stats stats() const;  // thread-safe

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
