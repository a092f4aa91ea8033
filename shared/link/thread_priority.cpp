#include "shared/link/thread_priority.h"

#include <cerrno>
#include <cstring>
#include <exception>
#include <thread>

#include <sched.h>
#include <sys/prctl.h>

namespace palpate {
namespace {

// Returns a text for the rejected request.
std::string Become(int policy, int priority) {
  std::string refused;
  if (prctl(PR_SET_TIMERSLACK, 1UL) != 0) {
    refused = std::string("timer slack stays 50 us: ") + std::strerror(errno);
  }
  sched_param parameters{};
  parameters.sched_priority = priority;
  // The argument 0 is the calling thread (sched_setscheduler(2), Linux).
  if (sched_setscheduler(0, policy, &parameters) != 0) {
    if (!refused.empty()) refused += "; ";
    refused += std::string("no real-time priority: ") + std::strerror(errno);
  }
  return refused;
}

}  // namespace

std::string MakeThreadRealtime(int priority) {
  return Become(SCHED_FIFO | SCHED_RESET_ON_FORK, priority);
}

void MakeWithRealtimeThreads(int priority, const std::function<void()>& make) {
  std::exception_ptr error;
  std::jthread([&] {
    Become(SCHED_FIFO, priority);
    try {
      make();
    } catch (...) {
      error = std::current_exception();
    }
  }).join();
  if (error) std::rethrow_exception(error);
}

ScopedPriority::ScopedPriority(int policy, int priority) : policy_(sched_getscheduler(0)) {
  sched_param parameters{};
  sched_getparam(0, &parameters);
  priority_ = parameters.sched_priority;
  parameters.sched_priority = priority;
  sched_setscheduler(0, policy, &parameters);
}

ScopedPriority::~ScopedPriority() {
  sched_param parameters{};
  parameters.sched_priority = priority_;
  sched_setscheduler(0, policy_, &parameters);
}

OrdinaryPriority::OrdinaryPriority() : ScopedPriority(SCHED_OTHER, 0) {}
// Does not use SCHED_RESET_ON_FORK, because clearing it needs a privilege.
ReadingPriority::ReadingPriority() : ScopedPriority(SCHED_FIFO, kReadingPriority) {}

}  // namespace palpate
