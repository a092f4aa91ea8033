// Requests of the operator during a session, besides the device's switch. Any thread may write
// them. The haptic loop reads them at each tick, wait-free.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "master/haptics/render_mode.h"

namespace palpate {

struct OperatorRequests {
  explicit OperatorRequests(RenderMode mode) : render(mode) {}

  std::atomic<std::uint32_t> marks{0};  // events marked so far
  std::atomic<std::uint32_t> tares{0};  // requested so far
  // Disengages regardless of the device's switch. When it ends, a closed switch begins a new
  // engagement.
  std::atomic<bool> clutched{false};
  std::atomic<RenderMode> render;  // becomes active while disengaged
  // Acts at once, and only if it is below the present limit [N], > 0.
  std::atomic<double> force_limit{std::numeric_limits<double>::infinity()};
  static_assert(std::atomic<double>::is_always_lock_free);
  static_assert(std::atomic<RenderMode>::is_always_lock_free);
};

}  // namespace palpate
