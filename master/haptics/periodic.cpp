#include "master/haptics/periodic.h"

#include <cerrno>
#include <cstring>

#include <sys/mman.h>

namespace palpate {

void WaitUntil(Time deadline) noexcept {
  const auto since = Clock::ToSteady(deadline).time_since_epoch();
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(since);
  timespec at{};
  at.tv_sec = static_cast<std::time_t>(whole.count());
  at.tv_nsec = static_cast<long>(std::chrono::nanoseconds(since - whole).count());
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
  }
}

std::string LockMemory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) return {};
  return std::string("memory is not locked: ") + std::strerror(errno);
}

}  // namespace palpate
