// Data of the slave as received by the link and used by the haptic loop. Plain values.
#pragma once

#include <cstdint>
#include <string>

#include "shared/geometry/teleop_transform.h"
#include "shared/state/clock.h"
#include "shared/state/dead_after.h"
#include "shared/state/slave_state.h"
#include "shared/state/surface_patch.h"

namespace palpate {

// A received state.
struct ReceivedState {
  SlaveState state;
  // Master's clock. If observed: when it would have arrived by the fastest way.
  Time received_at{};
  double clock_offset = 0;  // slave's clock minus master's [s], by the best of recent round trips
  double round_trip = 0;    // of the newest echoed command [s]
  bool ended = false;       // the stream ended after this one
  bool observed = false;    // this master does not operate: only phase and stops are used
};

// Settings of the slave that the master uses.
struct RemoteSettings {
  std::uint32_t revision = 0;           // 0: the slave sends none
  TeleopTransform transform;            // offset zero
  double force_limit = 0;               // on the device [N], > 0
  double dead_after = kUsualDeadAfter;  // link timeout without a state [s]
  double max_age = 0.2;                 // of a rendered sample, without its network delay [s]
};

// A complete received local contact model.
struct ReceivedPatch {
  SurfacePatch patch;  // its epoch rises also from stream to stream
  PatchLaw law;        // its newest force-depth curve
};

// Messages of local contact models.
struct PatchStats {
  std::uint64_t patches = 0, laws = 0, refused = 0;  // refused: rejected as invalid
  std::uint64_t bytes = 0;                           // of all received messages
  std::string trouble;  // why none arrives, or why the last was rejected
};

}  // namespace palpate
