#include "master/haptics/spsc_ring.h"

#include <thread>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(SpscRingTest, KeepsTheOrderAndCountsWhatItDrops) {
  SpscRing<int> ring(3);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(ring.Push(i), i < 3);
  EXPECT_EQ(ring.dropped(), 2U);
  int value = -1;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(ring.Pop(&value));
    EXPECT_EQ(value, i);
  }
  EXPECT_FALSE(ring.Pop(&value));
}

TEST(SpscRingTest, NothingIsLostTornOrReorderedBetweenTwoThreads) {
  struct Pair {
    std::uint64_t a = 0, b = 0;
  };
  constexpr std::uint64_t kCount = 100000;
  SpscRing<Pair> ring(64);
  std::jthread writer([&](const std::stop_token& stop) {
    for (std::uint64_t i = 1; i <= kCount && !stop.stop_requested();) {
      if (ring.Push({i, ~i})) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  Pair pair;
  for (std::uint64_t i = 1; i <= kCount;) {
    if (!ring.Pop(&pair)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(pair.a, i);
    ASSERT_EQ(pair.b, ~i);
    ++i;
  }
}

}  // namespace
}  // namespace palpate
