// Lets one page at a time control the pointer. Each change of page needs a new engagement.
#pragma once

#include <cstdint>
#include <set>

#include "shared/state/clock.h"

namespace palpate {

// Not thread-safe: used by the server's thread.
class PointerControlLock {
 public:
  // Processes a message of `page` at `now`. Returns whether the page has control. False: another
  // page has control, or had it when this page engaged; this page must then disengage first.
  // Control ends when the page disengages, leaves, or is silent for Pointer::kSilence and another
  // page engages.
  bool Hears(std::uint64_t page, bool engaged, Time now);
  // Removes `page`. True: it had control.
  bool Leaves(std::uint64_t page);

 private:
  std::uint64_t leader_ = 0;           // 0: none
  Time heard_at_{};                    // last message of the leader
  std::set<std::uint64_t> too_early_;  // pages that engaged while another had control
};

}  // namespace palpate
