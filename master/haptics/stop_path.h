// The emergency stop's own way from who asks for it to the slave, on threads of its own: with each
// command, as the haptic loop does by itself, and by a call, which a station that does not operate
// has, too.
#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "master/haptics/haptic_loop.h"

namespace palpate {

class StopPath {
 public:
  struct Ways {
    std::function<bool()> asked;  // asked every few milliseconds; empty: never
    std::function<bool()> call;  // of the slave's Stop; true: it stands. May take long; empty: none
    std::function<void()> give_up = {};  // ends the call that is under way; with `call`
  };
  // `loop` outlives it.
  StopPath(HapticLoop& loop, Ways ways);
  // A stop that was asked for has a second left to act.
  ~StopPath();
  StopPath(const StopPath&) = delete;
  StopPath& operator=(const StopPath&) = delete;

 private:
  HapticLoop& loop_;
  std::function<void()> give_up_;
  std::atomic<bool> calls_{false};  // the thread is there
  std::jthread watching_, calling_;
};

}  // namespace palpate
