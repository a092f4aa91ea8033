#include "shared/link/latest_value.h"

#include <algorithm>
#include <array>
#include <thread>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// A value is inconsistent if its numbers differ. The sequence read must only rise and end at the
// last one written.
TEST(LatestValueTest, AReaderNeverSeesATornOrOlderValue) {
  using Block = std::array<std::uint64_t, 32>;
  constexpr std::uint64_t kLast = 500'000;
  LatestValue<Block> value;
  std::jthread writer([&] {
    Block block;
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      block.fill(i);
      value.Put(block);
    }
  });
  std::uint64_t seen = 0, torn = 0, backwards = 0;
  while (seen < kLast) {
    const Block* block = value.Take();
    if (block == nullptr) continue;
    torn += std::count(block->begin(), block->end(), block->front()) != 32 ? 1U : 0U;
    backwards += block->front() <= seen ? 1U : 0U;
    seen = block->front();
  }
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(backwards, 0U);
}

}  // namespace
}  // namespace palpate
