#include "shared/link/thread_priority.h"

#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>
#include <sched.h>

namespace palpate {
namespace {

int Policy() {
  return sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
}

// Reference: sched(7). A process without the permission gets a report and keeps its priority.
TEST(ThreadPriorityTest, IsNotInheritedByNewThreads) {
  std::string refused;
  int own = -1, childs = -1;
  std::thread([&] {
    refused = MakeThreadRealtime(kLinkPriority);
    own = Policy();
    std::thread([&] { childs = Policy(); }).join();
  }).join();
  const bool allowed = refused.find("no real-time priority") == std::string::npos;
  EXPECT_EQ(own == SCHED_FIFO, allowed) << refused;
  EXPECT_EQ(childs, SCHED_OTHER);
}

TEST(ThreadPriorityTest, ThreadsMadeInsideAreUrgentTheCallerIsNot) {
  int childs = -1, meanwhile = -1, afterwards = -1, reading = -1;
  MakeWithRealtimeThreads(kReadingPriority, [&] {
    std::thread([&] {
      childs = Policy();
      {
        const OrdinaryPriority ordinary;
        meanwhile = Policy();
        const ReadingPriority again;
        reading = Policy();
      }
      afterwards = Policy();
    }).join();
  });
  std::string refused;
  std::thread([&] { refused = MakeThreadRealtime(kReadingPriority); }).join();
  const bool allowed = refused.find("no real-time priority") == std::string::npos;
  EXPECT_EQ(childs, allowed ? SCHED_FIFO : SCHED_OTHER);
  EXPECT_EQ(meanwhile, SCHED_OTHER);
  EXPECT_EQ(reading, childs);
  EXPECT_EQ(afterwards, childs);
  EXPECT_EQ(Policy(), SCHED_OTHER);
  EXPECT_THROW(MakeWithRealtimeThreads(kReadingPriority, [] { throw std::logic_error("no"); }),
               std::logic_error);
}

}  // namespace
}  // namespace palpate
