#include "slave/mechanics/linear/lanes.h"

#include <array>

#include <gtest/gtest.h>

namespace palpate::fem {
namespace {

// Compiled for the baseline, whose aligned instructions fault: an answer is what is asked for.
// Places come from outside, so that the compiler knows none.
TEST(LanesTest, FourNumbersAreReadAndWrittenAnywhere) {
  alignas(32) std::array<double, 16> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(i);
  for (int at = 0; at < 4; ++at) {
    volatile int place = at;
    double* from = numbers.data() + place;
    const Double4 twice = Load4(from) + Load4(from + 3) * 2;
    EXPECT_EQ(twice[3], at + 3 + 2 * (at + 6));
    Store4(from + 7, twice);
    EXPECT_EQ(numbers[static_cast<std::size_t>(at) + 7], at + 2 * (at + 3));
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(i);
  }
}

}  // namespace
}  // namespace palpate::fem
