#include "master/station/tick_digest.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

const Time kBegin{std::chrono::hours(1)};

TickRecord At(double t, double sent = 0, double age = 0.001) {
  TickRecord tick;
  tick.at = kBegin + std::chrono::microseconds(std::llround(t * 1e6));
  tick.chain.sent = {0, sent, 0};
  tick.state_age = age;
  return tick;
}

TEST(TickDigestTest, NothingIsNothing) {
  const TickDigest digest;
  EXPECT_FALSE(digest.Newest().any);
}

TEST(TickDigestTest, CountsTheRateAndWhatWasMissed) {
  TickDigest digest;
  for (int i = 0; i <= 3000; ++i) {
    if (i >= 1500 && i < 1505) continue;
    digest.Add(At(1e-3 * i));
  }
  const TickDigest::Moment moment = digest.Newest();
  EXPECT_EQ(moment.missed, 5U);
  EXPECT_NEAR(moment.t, 3, 1e-9);
  EXPECT_NEAR(moment.rate, 1000, 2);
}

// A press of a single tick is in the charts, which show a tenth of the ticks.
TEST(TickDigestTest, NoPeakIsLost) {
  TickDigest digest;
  for (int i = 0; i < 100; ++i) digest.Add(At(1e-3 * i, i == 55 ? 2.5 : 0.1));
  double peak = 0;
  for (const TickSample& sample : digest.Newest().samples) peak = std::max(peak, sample.sent);
  EXPECT_EQ(peak, 2.5);
}

// A sample ends with a tick, so it is 10 ms long but for one of them.
TEST(TickDigestTest, SamplesAreTheNewestQuarterOfASecondInOrder) {
  TickDigest digest;
  for (int i = 0; i < 2000; ++i) digest.Add(At(1e-3 * i));
  const auto samples = digest.Newest().samples;
  ASSERT_EQ(samples.size(), 25U);
  EXPECT_GT(samples.back().t, 1.98);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].number, samples[i - 1].number + 1);
    EXPECT_NEAR(samples[i].t - samples[i - 1].t, 0.010, 1.001e-3);
  }
}

TEST(TickDigestTest, ThePastIsOfTenSeconds) {
  TickDigest digest;
  for (int i = 0; i < 15000; ++i) digest.Add(At(1e-3 * i));
  const auto past = digest.Past();
  ASSERT_EQ(past.size(), 1000U);
  EXPECT_EQ(past.back().number, digest.Newest().samples.back().number);
  EXPECT_GE(past.back().t - past.front().t, 9.98);
}

TEST(TickDigestTest, LatenessIsAShareOfTheLastTenSeconds) {
  TickDigest digest;
  for (int i = 0; i < 40000; ++i) {
    const double t = 1e-3 * i;
    digest.Add(At(t, 0, t > 30 && t < 32 ? 0.1 : 0.001));
  }
  EXPECT_NEAR(digest.Newest().late_share, 0.2, 0.02);
}

}  // namespace
}  // namespace palpate
