#include "master/station/tick_digest.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

const Time kDigestBegin{std::chrono::hours(1)};

TickRecord DigestTick(double t, double sent = 0, double age = 0.001) {
  TickRecord tick;
  tick.at = kDigestBegin + std::chrono::microseconds(std::llround(t * 1e6));
  tick.chain.sent = {0, sent, 0};
  tick.state_age = age;
  return tick;
}

TEST(TickDigestTest, CountsTheRateAndWhatWasMissed) {
  TickDigest digest;
  for (int i = 0; i <= 3000; ++i) {
    if (i >= 1500 && i < 1505) continue;
    digest.Add(DigestTick(1e-3 * i));
  }
  const TickDigest::Moment moment = digest.Newest();
  EXPECT_EQ(moment.missed, 5U);
  EXPECT_NEAR(moment.t, 3, 1e-9);
  EXPECT_NEAR(moment.rate, 1000, 2);
}

// A press of a single tick is in the charts, which show a tenth of the ticks.
TEST(TickDigestTest, NoPeakIsLost) {
  TickDigest digest;
  for (int i = 0; i < 100; ++i) digest.Add(DigestTick(1e-3 * i, i == 55 ? 2.5 : 0.1));
  double peak = 0;
  for (const TickSample& sample : digest.Newest().samples) peak = std::max(peak, sample.sent);
  EXPECT_EQ(peak, 2.5);
}

}  // namespace
}  // namespace palpate
