// A whole run: haptic loop, bare loops beside it, and the slow thread that records and shows.
#pragma once

#include <functional>

#include "master/haptics/record/report.h"

namespace palpate {

// A fingertip, or the tool of a scene without several, as of the newest state.
struct NamedFinger {
  std::string name;
  FingerState felt;
};

// What the operator sees while it runs.
struct Status {
  double t = 0;  // [s] since the run began
  TickRecord tick;
  double rate = 0;                   // ticks per second over the last while [Hz]
  double force_limit = 0;            // [N]
  std::vector<NamedFinger> fingers;  // in the scene's order; empty: no state yet
  LinkStats link;
};

struct SessionOptions {
  HapticLoop::Options loop;
  std::vector<std::string> finger_names;  // in the scene's order; those it lacks are numbered
  double duration = 0;        // [s]; 0: until stopped, or until the device's motion is over
  std::filesystem::path log;  // empty: none
};

// Runs with the calling thread as the slow one. `stop_wanted` is asked every 10 ms, `show` called
// ten times a second. The device has zero force and the slave a command to stand when it returns.
// Throws std::runtime_error: the log cannot be written at the start.
Report RunSession(const SessionOptions& options, Device& device, LatestValue<ReceivedState>* states,
                  LatestValue<OperatorCommand>* commands, const std::function<LinkStats()>& link,
                  const std::function<bool()>& stop_wanted,
                  const std::function<void(const Status&)>& show);

}  // namespace palpate
