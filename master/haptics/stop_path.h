// The emergency stop's own way from who asks for it to the slave, on threads of its own: with each
// command, as the haptic loop does by itself, and by a call, which a station that does not operate
// has, too.
#pragma once

#include <functional>
#include <thread>

#include "master/haptics/haptic_loop.h"

namespace palpate {

class StopPath {
 public:
  struct Ways {
    std::function<bool()> asked;  // asked every few milliseconds; empty: never
    std::function<bool()> call;  // of the slave's Stop; true: it stands. May take long; empty: none
  };
  // `loop` outlives it. Ends with what is under way.
  StopPath(HapticLoop& loop, Ways ways);

 private:
  std::jthread watching_, calling_;
};

}  // namespace palpate
