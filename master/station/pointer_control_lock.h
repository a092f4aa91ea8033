// Which of the station's pages leads the hand: one at a time, each by an engagement of its own.
#pragma once

#include <cstdint>
#include <set>

#include "shared/state/clock.h"

namespace palpate {

// Not thread-safe: the server's thread.
class PointerControlLock {
 public:
  // What page `page` says at `now`: that it holds the hand, or not. True: it is the one to be
  // followed. False: another page leads, or led when this one took hold, which has to let go first.
  // A page leads until it lets go, leaves, or another takes hold when this one was silent for
  // Pointer::kSilence: the pointer has let go by itself then.
  bool Hears(std::uint64_t page, bool engaged, Time now);
  // `page` is gone. True: it led.
  bool Leaves(std::uint64_t page);

 private:
  std::uint64_t leader_ = 0;           // 0: none
  Time heard_at_{};                    // the leader
  std::set<std::uint64_t> too_early_;  // pages that hold since another one led
};

}  // namespace palpate
