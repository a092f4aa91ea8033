#include "slave/vision/stereo/frozen_check.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace palpate {
namespace {

cv::Mat Noisy(int seed) {
  cv::RNG random(static_cast<std::uint64_t>(seed) + 1);
  cv::Mat picture(48, 64, CV_8UC1);
  random.fill(picture, cv::RNG::UNIFORM, 0, 255);
  return picture;
}

TEST(FrozenCheckTest, APictureThatComesAgainIsFrozenWhicheverEyesItIs) {
  FrozenCheck check(3);
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(check.See(Noisy(i), Noisy(100 + i)));
  EXPECT_TRUE(check.See(Noisy(5), Noisy(106)));
  EXPECT_FALSE(check.See(Noisy(7), Noisy(107)));
  EXPECT_TRUE(check.See(Noisy(8), Noisy(107)));
  EXPECT_TRUE(check.See(Noisy(8), Noisy(107)));
}

TEST(FrozenCheckTest, PairsThatComeTwiceAreTheSameAgain) {
  FrozenCheck check(10);
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(check.See(Noisy(i / 2), Noisy(100 + i / 2)), i % 2 == 1 && i > 2) << i;
  }
}

TEST(FrozenCheckTest, WithoutNoiseARepeatSaysNothing) {
  FrozenCheck check(3);
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(check.See(Noisy(1), Noisy(2)));
  EXPECT_FALSE(check.See(Noisy(1), Noisy(3)));
  EXPECT_FALSE(check.See({}, {}));
  EXPECT_FALSE(check.See({}, {}));
}

}  // namespace
}  // namespace palpate
