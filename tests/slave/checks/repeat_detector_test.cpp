#include "slave/checks/repeat_detector.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace palpate {
namespace {

cv::Mat Noisy(int seed) {
  cv::RNG random(static_cast<std::uint64_t>(seed) + 1);
  cv::Mat image(48, 64, CV_8UC1);
  random.fill(image, cv::RNG::UNIFORM, 0, 255);
  return image;
}

TEST(RepeatDetectorTest, ARepeatedImageIsFrozenInEitherCamera) {
  RepeatDetector detector({.learning = 5});
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(detector.Repeats(Noisy(i), Noisy(100 + i)));
  EXPECT_TRUE(detector.Repeats(Noisy(5), Noisy(106)));
  EXPECT_FALSE(detector.Repeats(Noisy(7), Noisy(107)));
  EXPECT_TRUE(detector.Repeats(Noisy(8), Noisy(107)));
  EXPECT_TRUE(detector.Repeats(Noisy(8), Noisy(107)));
}

// A camera without noise whose view contains a moving tool, at a standstill.
TEST(RepeatDetectorTest, AMotionInAPartOfTheViewIsNoNoise) {
  const auto with_tool = [](int at) {
    cv::Mat image(480, 640, CV_8UC1, cv::Scalar(90));
    image(cv::Rect(300, 0, 40, 100 + at)) = cv::Scalar(30);
    return image;
  };
  RepeatDetector detector({.learning = 30, .noisy_share = 0.9});
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(detector.Repeats(with_tool(8 * i)));
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(detector.Repeats(with_tool(160)));
}

TEST(RepeatDetectorTest, WithoutNoiseARepeatIsNoEvidence) {
  RepeatDetector detector({.learning = 5});
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(detector.Repeats(Noisy(1), Noisy(2)));
  EXPECT_FALSE(detector.Repeats(Noisy(1), Noisy(3)));
  EXPECT_FALSE(detector.Repeats({}, {}));
  EXPECT_FALSE(detector.Repeats({}, {}));
}

}  // namespace
}  // namespace palpate
