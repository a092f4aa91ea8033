#include "tests/support/normal_noise.h"

#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

template <class Engine>
void ExpectTheLibrarysNumbers() {
  Engine ours(7), theirs(7);
  NormalNoise noise;
  std::normal_distribution<double> library(0, 1);
  for (int i = 0; i < 10'000; ++i) ASSERT_EQ(noise(ours), library(theirs)) << i;
}

TEST(NormalNoise, IsTheLibrarysBitForBit) {
  ExpectTheLibrarysNumbers<std::mt19937_64>();
  ExpectTheLibrarysNumbers<std::mt19937>();
}

}  // namespace
}  // namespace palpate
