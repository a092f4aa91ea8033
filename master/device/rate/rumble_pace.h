// RumblePace decides when a rumble command is sent to a game controller.
#pragma once

#include <cstdint>

#include "shared/state/clock.h"

namespace palpate {

// Pads over Bluetooth take one command in 50 ms, and some stop by themselves.
class RumblePace {
 public:
  static constexpr double kMinDuration = 0.050, kRepeat = 0.100;  // [s]
  static constexpr std::uint32_t kLasts = 200;                    // of one command [ms]
  static constexpr double kDeadZone = 0.03;  // a smaller force is not shown [-]

  // Returns whether to send `share` [-] now; then it is the last one sent.
  bool Send(double share, Time now) {
    const double shown = share < kDeadZone ? 0 : share;
    const double since = SecondsBetween(sent_at_, now);
    const bool is_due = shown != last_ ? since >= kMinDuration : shown > 0 && since >= kRepeat;
    if (!is_due) return false;
    last_ = shown;
    sent_at_ = now;
    return true;
  }

 private:
  double last_ = 0;
  Time sent_at_{};
};

}  // namespace palpate
