#include "shared/link/thread_priority.h"

#include <thread>

#include <gtest/gtest.h>
#include <sched.h>

namespace palpate {
namespace {

int Policy() {
  return sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
}

// Reference: sched(7). Whoever lacks the permission is told so and goes on as before.
TEST(ThreadPriorityTest, IsTheThreadsOwnAndNotThatOfThoseItStarts) {
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

TEST(ThreadPriorityTest, AnImpossiblePriorityIsRefusedInWords) {
  std::string refused;
  std::thread([&] { refused = MakeThreadRealtime(1000); }).join();
  EXPECT_NE(refused.find("no real-time priority: "), std::string::npos) << refused;
}

TEST(ThreadPriorityTest, WhatHoldsAHandGoesFirst) {
  EXPECT_GT(kHapticPriority, kLinkPriority);
  EXPECT_GT(kLinkPriority, kEyesPriority);
}

}  // namespace
}  // namespace palpate
