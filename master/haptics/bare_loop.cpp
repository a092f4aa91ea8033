#include "master/haptics/bare_loop.h"

#include <algorithm>

#include "shared/link/thread_priority.h"

namespace palpate {

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
