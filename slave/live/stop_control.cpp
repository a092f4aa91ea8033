#include "slave/live/stop_control.h"

#include <cstdint>
#include <stdexcept>

namespace palpate {

std::string StopControl::Stop(const std::string& reason) {
  port_.EmergencyStop();  // at once: the record may wait for the disk
  const std::scoped_lock lock(mutex_);
  const bool was_reset = port_.view().phase != Phase::kEstop;
  if (was_reset || record_.is_active()) return {};
  return record_.Begin(reason);
}

void StopControl::Reset() {
  const std::uint64_t stops = port_.stops();
  const std::scoped_lock lock(mutex_);
  record_.End();
  if (port_.Reset(stops)) return;
  throw std::logic_error("another emergency stop arrived during the reset: it remains");
}

}  // namespace palpate
