#include "master/haptics/periodic.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <sys/mman.h>

#include "shared/link/thread_priority.h"

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

BareLoops::BareLoops(Clock::duration length, int priority) {
  for (std::size_t i = 0; i < kCount; ++i) {
    threads_[i] = std::jthread([this, i, length, priority](const std::stop_token& stop) {
      MakeThreadRealtime(priority);
      RunPeriodically(length, stop, &stats_[i], [] { return true; });
    });
  }
}

void BareLoops::Stop() {
  for (auto& thread : threads_) thread.request_stop();
  for (auto& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

std::array<std::uint64_t, BareLoops::kCount> BareLoops::missed() const {
  std::array<std::uint64_t, kCount> missed{};
  for (std::size_t i = 0; i < kCount; ++i) missed[i] = stats_[i].missed;
  std::sort(missed.begin(), missed.end());
  return missed;
}

}  // namespace palpate
