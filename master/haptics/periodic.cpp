#include "master/haptics/periodic.h"

#include <cerrno>
#include <cstring>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>

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

std::string MakeThreadRealtime(int priority) {
  std::string refused;
  if (prctl(PR_SET_TIMERSLACK, 1UL) != 0) {
    refused = std::string("timer slack stays 50 us: ") + std::strerror(errno);
  }
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error != 0) {
    if (!refused.empty()) refused += "; ";
    refused += std::string("no real-time priority: ") + std::strerror(error);
  }
  return refused;
}

std::string LockMemory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) return {};
  return std::string("memory is not locked: ") + std::strerror(errno);
}

}  // namespace palpate
