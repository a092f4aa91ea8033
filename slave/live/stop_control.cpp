#include "slave/live/stop_control.h"

#include <cstdint>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

namespace palpate {

std::string StopControl::Record(const std::string& reason) {
  const std::scoped_lock lock(mutex_);
  const bool was_reset = port_.view().phase != Phase::kEstop;
  if (was_reset || record_.is_active()) return {};
  return record_.Begin(reason);
}

void StopControl::Reset(std::uint64_t stops) {
  const std::scoped_lock lock(mutex_);
  const std::uint64_t newest = port_.stops();
  if (stops == 0) {
    throw std::logic_error(
        "an emergency stop is active, and the reset names none: send the `stops` of the status");
  }
  if (stops != newest) {
    throw std::logic_error(fmt::format(
        "the reset is for emergency stop {}, but {} is the newest: it remains; read the status and "
        "reset again",
        stops, newest));
  }
  record_.End();
  if (port_.Reset(stops)) return;
  throw std::logic_error("another emergency stop arrived during the reset: it remains");
}

}  // namespace palpate
