// Lets one page at a time control the pointer. Each change of page needs a new engagement.
#pragma once

#include <cstdint>
#include <set>

#include "master/device/pointer.h"
#include "shared/state/clock.h"

namespace palpate {

// The lock is not thread-safe: it is used by the server's thread.
class PointerControlLock {
 public:
  // Processes a message of `page` at `now`. Returns whether the page has control. False: another
  // page has control, or had it when this page engaged; this page must then disengage first.
  // Control ends when the page disengages, leaves, or is silent for longer than its `max_silence`
  // [s] and another page engages.
  bool Hears(std::uint64_t page, bool engaged, Time now, double max_silence) {
    if (!engaged) too_early_.erase(page);
    const bool is_led =
        leader_ != 0 && leader_ != page && SecondsBetween(received_at_, now) <= max_silence_;
    if (is_led || too_early_.contains(page)) {
      if (engaged) too_early_.insert(page);
      return false;
    }
    if (!engaged && leader_ != page && leader_ != 0) return false;
    leader_ = engaged ? page : 0;
    received_at_ = now;
    max_silence_ = max_silence;
    return true;
  }
  // Removes `page`. True: it had control.
  bool Leaves(std::uint64_t page) {
    too_early_.erase(page);
    if (leader_ != page) return false;
    leader_ = 0;
    return true;
  }

 private:
  std::uint64_t leader_ = 0;           // 0: none
  Time received_at_{};                 // last message of the leader
  double max_silence_ = 0;             // of the leader [s]
  std::set<std::uint64_t> too_early_;  // pages that engaged while another had control
};

}  // namespace palpate
