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
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(check.Check(Noisy(i), Noisy(100 + i)));
  EXPECT_TRUE(check.Check(Noisy(5), Noisy(106)));
  EXPECT_FALSE(check.Check(Noisy(7), Noisy(107)));
  EXPECT_TRUE(check.Check(Noisy(8), Noisy(107)));
  EXPECT_TRUE(check.Check(Noisy(8), Noisy(107)));
}

TEST(FrozenCheckTest, PairsThatComeTwiceAreTheSameAgain) {
  FrozenCheck check(10);
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(check.Check(Noisy(i / 2), Noisy(100 + i / 2)), i % 2 == 1 && i > 2) << i;
  }
}

TEST(FrozenCheckTest, WithoutNoiseARepeatSaysNothing) {
  FrozenCheck check(3);
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(check.Check(Noisy(1), Noisy(2)));
  EXPECT_FALSE(check.Check(Noisy(1), Noisy(3)));
  EXPECT_FALSE(check.Check({}, {}));
  EXPECT_FALSE(check.Check({}, {}));
}

// As a line leaves them that loses blocks of 16 pixels: the decoder shows what was there.
TEST(FrozenCheckTest, BlocksOfTheLastOrTheFirstPictureAreSeen) {
  FrozenCheck check(3);
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(check.Check(Noisy(i), Noisy(100 + i)));
  const cv::Rect blocks(16, 16, 32, 16), sliver(16, 16, 16, 16);
  cv::Mat partly = Noisy(6);
  Noisy(5)(blocks).copyTo(partly(blocks));
  EXPECT_TRUE(check.Check(partly, Noisy(106)));
  cv::Mat other = Noisy(107);
  Noisy(100)(blocks).copyTo(other(blocks));
  EXPECT_TRUE(check.Check(Noisy(7), other));
  cv::Mat little = Noisy(8);
  Noisy(7)(sliver).copyTo(little(sliver));
  EXPECT_FALSE(check.Check(little, Noisy(108)));
}

TEST(FrozenCheckTest, BlocksOfTheFirstPictureAreSeenWhereTheyCameFromTheStart) {
  FrozenCheck check(6);
  for (int i = 0; i < 20; ++i) {
    cv::Mat picture = Noisy(i);
    const cv::Rect lost(16 * (i % 4), 0, 16, 48);
    Noisy(0)(lost).copyTo(picture(lost));
    EXPECT_EQ(check.Check(picture, Noisy(100 + i)), i >= 6) << i;
  }
}

// Compression gives the same block for other noise; what covers the picture has none at all.
TEST(FrozenCheckTest, PartsThatRepeatFromTheStartOrHaveNoNoiseSayNothing) {
  FrozenCheck compressed(4), covered(4);
  const cv::Rect blocks(16, 16, 32, 16);
  for (int i = 0; i < 9; ++i) {
    cv::Mat picture = Noisy(i), cover = Noisy(i);
    Noisy(50)(blocks).copyTo(picture(blocks));
    if (i > 4) cover(blocks) = 90;
    EXPECT_FALSE(compressed.Check(picture, Noisy(100 + i))) << i;
    EXPECT_FALSE(covered.Check(cover, Noisy(100 + i))) << i;
  }
}

}  // namespace
}  // namespace palpate
