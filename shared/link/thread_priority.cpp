#include "shared/link/thread_priority.h"

#include <cerrno>
#include <cstring>

#include <sched.h>
#include <sys/prctl.h>

namespace palpate {

std::string MakeThreadRealtime(int priority) {
  std::string refused;
  if (prctl(PR_SET_TIMERSLACK, 1UL) != 0) {
    refused = std::string("timer slack stays 50 us: ") + std::strerror(errno);
  }
  sched_param parameters{};
  parameters.sched_priority = priority;
  // 0: the calling thread (sched_setscheduler(2), Linux).
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) != 0) {
    if (!refused.empty()) refused += "; ";
    refused += std::string("no real-time priority: ") + std::strerror(errno);
  }
  return refused;
}

}  // namespace palpate
