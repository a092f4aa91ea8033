#include <gtest/gtest.h>

#include "master/haptics/record/recorder.h"
#include "master/haptics/record/tick_summary.h"

namespace palpate {
namespace {

// Reference: worked out by hand; ticks below the threshold do not count, whichever force is larger.
TEST(ForceErrorTest, CountsTheTicksInWhichEitherForceIsLargeEnough) {
  ForceError error;
  EXPECT_TRUE(error.empty());
  error.Add({0, 2.0, 0}, {0, 1.9, 0});
  error.Add({0, 0, 0}, {0, 0.3, 0});       // only the truth
  error.Add({0.4, 0, 0}, {0, 0, 0});       // only ours
  error.Add({0, 0.01, 0}, {0, 0.015, 0});  // neither
  error.Add({0, 0, 0}, {0, 0, 0});
  const ForceError::Summary summary = error.Above(0.02);
  EXPECT_EQ(summary.ticks, 3U);
  EXPECT_NEAR(summary.peak, 0.4, 1e-12);
  EXPECT_NEAR(summary.rms, std::sqrt((0.01 + 0.09 + 0.16) / 3), 1e-12);
}

TEST(ForceErrorTest, HugeAndTinyForcesHaveAPlace) {
  ForceError error;
  error.Add({1e200, 0, 0}, {0, 0, 0});
  error.Add({1e-200, 0, 0}, {0, 0, 0});
  EXPECT_EQ(error.Above(1).ticks, 1U);
}

TEST(TruthTrackTest, IsLinearBetweenItsSamplesAndSilentElsewhere) {
  const Time start{std::chrono::hours(1)};
  TruthTrack track;
  EXPECT_FALSE(track.At(start));
  track.Add(start, {0, 1, 0});
  track.Add(start + std::chrono::milliseconds(10), {0, 2, 0});
  track.Add(start + std::chrono::milliseconds(5), {0, 9, 0});  // late: ignored
  EXPECT_NEAR(track.At(start + std::chrono::milliseconds(3))->y(), 1.3, 1e-12);
  EXPECT_EQ(track.At(start)->y(), 1);
  EXPECT_FALSE(track.At(start - std::chrono::milliseconds(1)));
  EXPECT_FALSE(track.At(start + std::chrono::milliseconds(11)));
  track.Add(start + std::chrono::milliseconds(300), {0, 5, 0});
  EXPECT_FALSE(track.At(start + std::chrono::milliseconds(100))) << "across a gap";
  track.DropBefore(start + std::chrono::milliseconds(8));
  EXPECT_TRUE(track.At(start + std::chrono::milliseconds(8)));
}

}  // namespace
}  // namespace palpate
