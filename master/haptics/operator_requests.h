// What the operator asks of the hand while it runs, beside the device's own switch. Any thread
// asks, the haptic loop looks at each tick; wait-free.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "master/haptics/render_mode.h"

namespace palpate {

struct OperatorRequests {
  explicit OperatorRequests(RenderMode mode) : render(mode) {}

  std::atomic<std::uint32_t> marks{0};  // events marked so far
  std::atomic<std::uint32_t> tares{0};  // asked for so far
  // The hand is let go, whatever the device's switch says. Its end is an act: a closed switch
  // engages anew.
  std::atomic<bool> clutched{false};
  std::atomic<RenderMode> render;  // comes in force while nobody follows
  // Counts at once, and only where it is less than what counts already [N], > 0.
  std::atomic<double> force_limit{std::numeric_limits<double>::infinity()};
  static_assert(std::atomic<double>::is_always_lock_free);
  static_assert(std::atomic<RenderMode>::is_always_lock_free);
};

}  // namespace palpate
