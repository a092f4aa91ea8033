#include "slave/checks/repeat_detector.h"

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

bool Repeats(RepeatDetector& detector, const cv::Mat& left, const cv::Mat& right) {
  return detector.Find(left, right) != Repeat::kNothing;
}

TEST(RepeatDetectorTest, APictureThatComesAgainIsFrozenWhicheverEyesItIs) {
  RepeatDetector detector({.learning = 3});
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(Repeats(detector, Noisy(i), Noisy(100 + i)));
  EXPECT_TRUE(Repeats(detector, Noisy(5), Noisy(106)));
  EXPECT_FALSE(Repeats(detector, Noisy(7), Noisy(107)));
  EXPECT_TRUE(Repeats(detector, Noisy(8), Noisy(107)));
  EXPECT_TRUE(Repeats(detector, Noisy(8), Noisy(107)));
}

TEST(RepeatDetectorTest, PairsThatComeTwiceAreTheSameAgain) {
  RepeatDetector detector({.learning = 10});
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(Repeats(detector, Noisy(i / 2), Noisy(100 + i / 2)), i % 2 == 1 && i > 2) << i;
  }
}

TEST(RepeatDetectorTest, WithoutNoiseARepeatSaysNothing) {
  RepeatDetector detector({.learning = 3});
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(Repeats(detector, Noisy(1), Noisy(2)));
  EXPECT_FALSE(Repeats(detector, Noisy(1), Noisy(3)));
  EXPECT_FALSE(Repeats(detector, {}, {}));
  EXPECT_FALSE(Repeats(detector, {}, {}));
}

TEST(RepeatDetectorTest, KnownNoiseNeedsNoLearningAndPartsCountWhereTheyAreLookedFor) {
  RepeatDetector whole({.has_noise = true, .parts = false}), parts({.has_noise = true});
  cv::Mat partly = Noisy(2);
  Noisy(1)(cv::Rect(16, 16, 32, 16)).copyTo(partly(cv::Rect(16, 16, 32, 16)));
  for (RepeatDetector* detector : {&whole, &parts}) {
    EXPECT_EQ(detector->Find(Noisy(1)), Repeat::kNothing);
    EXPECT_EQ(detector->Find(Noisy(1)), Repeat::kWhole);
    EXPECT_EQ(detector->Find(partly), detector == &whole ? Repeat::kNothing : Repeat::kParts);
  }
}

// As a line leaves them that loses blocks of 16 pixels: the decoder shows what was there.
TEST(RepeatDetectorTest, BlocksOfTheLastOrTheFirstPictureAreSeen) {
  RepeatDetector detector({.learning = 3});
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(Repeats(detector, Noisy(i), Noisy(100 + i)));
  const cv::Rect blocks(16, 16, 32, 16), sliver(16, 16, 16, 16);
  cv::Mat partly = Noisy(6);
  Noisy(5)(blocks).copyTo(partly(blocks));
  EXPECT_TRUE(Repeats(detector, partly, Noisy(106)));
  cv::Mat other = Noisy(107);
  Noisy(100)(blocks).copyTo(other(blocks));
  EXPECT_TRUE(Repeats(detector, Noisy(7), other));
  cv::Mat little = Noisy(8);
  Noisy(7)(sliver).copyTo(little(sliver));
  EXPECT_FALSE(Repeats(detector, little, Noisy(108)));
}

TEST(RepeatDetectorTest, BlocksOfTheFirstPictureAreSeenWhereTheyCameFromTheStart) {
  RepeatDetector detector({.learning = 6});
  for (int i = 0; i < 20; ++i) {
    cv::Mat picture = Noisy(i);
    const cv::Rect lost(16 * (i % 4), 0, 16, 48);
    Noisy(0)(lost).copyTo(picture(lost));
    EXPECT_EQ(Repeats(detector, picture, Noisy(100 + i)), i >= 6) << i;
  }
}

// Compression gives the same block for other noise; what covers the picture has none at all.
TEST(RepeatDetectorTest, PartsThatRepeatFromTheStartOrHaveNoNoiseSayNothing) {
  RepeatDetector compressed({.learning = 4}), covered({.learning = 4});
  const cv::Rect blocks(16, 16, 32, 16);
  for (int i = 0; i < 9; ++i) {
    cv::Mat picture = Noisy(i), cover = Noisy(i);
    Noisy(50)(blocks).copyTo(picture(blocks));
    if (i > 4) cover(blocks) = 90;
    EXPECT_FALSE(Repeats(compressed, picture, Noisy(100 + i))) << i;
    EXPECT_FALSE(Repeats(covered, cover, Noisy(100 + i))) << i;
  }
}

}  // namespace
}  // namespace palpate
