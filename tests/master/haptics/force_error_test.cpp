#include <gtest/gtest.h>

#include "master/session/recorder.h"
#include "master/session/tick_summary.h"

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

// A break that is reported three ticks later and fades in two; a truth that lags without one.
TEST(BreakingErrorTest, TicksFromTheBreakToNoForceAreCountedSeparately) {
  ForceError contact;
  BreakingError breaking;
  const auto tick = [&](double local, double truth, bool punctured) {
    breaking.Add({local, 0, 0}, {truth, 0, 0}, punctured, &contact);
  };
  tick(1, 1, false);
  tick(1, 0.7, false);  // late, and no puncture follows
  tick(1, 1, false);
  for (int i = 0; i < 3; ++i) tick(1, 0, false);
  EXPECT_EQ(contact.Above(0.01).ticks, 3U);
  tick(0.5, 0, true);
  tick(0.2, 0, true);
  tick(0, 0, true);
  tick(0, 0.5, true);  // the object pushes but no force is rendered: a contact error
  tick(1, 0.5, false);
  EXPECT_EQ(breaking.punctures(), 1U);
  EXPECT_EQ(breaking.longest(), 5U);
  EXPECT_EQ(breaking.error().Above(0.01).ticks, 5U);
  EXPECT_EQ(contact.Above(0.01).ticks, 4U);
  breaking.Close(&contact);
  EXPECT_EQ(contact.Above(0.01).ticks, 5U) << "no puncture was reported to its end";
}

TEST(TruthTrackTest, IsLinearBetweenItsSamplesAndUnknownElsewhere) {
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
