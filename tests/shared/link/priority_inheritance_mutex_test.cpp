#include "shared/link/priority_inheritance_mutex.h"

#include <atomic>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>
#include <sched.h>
#include <time.h>

#include "shared/link/thread_priority.h"

namespace palpate {
namespace {

// Processor time of the calling thread [s].
double ProcessorTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void StayOnOneProcessor() {
  cpu_set_t first;
  CPU_ZERO(&first);
  CPU_SET(0, &first);
  sched_setaffinity(0, sizeof first, &first);
}

// On one processor, a normal thread holds the mutex, a real-time thread occupies the processor, and
// a thread with higher priority waits for the mutex. Without priority inheritance the holder had
// only the 5 % of the processor that the system reserves for normal threads: it took 4 s.
TEST(PriorityInheritanceMutexTest, TheOwnerInheritsThePriorityOfWaitingThreads) {
  constexpr double kHeld = 0.2, kKept = 1;  // [s] of the processor
  PriorityInheritanceMutex mutex;
  std::atomic<bool> held{false}, keeps{false}, got{false}, refused{false};
  std::jthread holder([&] {
    StayOnOneProcessor();
    const std::scoped_lock lock(mutex);
    held = true;
    while (!keeps && !refused) std::this_thread::yield();
    for (const double begin = ProcessorTime(); !refused && ProcessorTime() - begin < kHeld;) {
    }
  });
  std::jthread waiter([&] {
    StayOnOneProcessor();
    refused = !MakeThreadRealtime(kLinkPriority).empty();
    while (!held || !(keeps || refused)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::scoped_lock lock(mutex);
    got = true;
  });
  bool in_time = false;
  std::jthread keeper([&] {
    StayOnOneProcessor();
    if (!MakeThreadRealtime(kSensingPriority).empty()) refused = true;
    while (!held && !refused) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    keeps = true;
    for (const double begin = ProcessorTime(); !got && ProcessorTime() - begin < kKept;) {
    }
    in_time = got;
  });
  keeper.join();
  waiter.join();
  if (refused) GTEST_SKIP() << "no real-time priorities here";
  EXPECT_TRUE(in_time);
}

}  // namespace
}  // namespace palpate
