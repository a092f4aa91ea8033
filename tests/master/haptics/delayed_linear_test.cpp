#include <cmath>

#include <gtest/gtest.h>

#include "master/haptics/renderer.h"

namespace palpate {
namespace {

Eigen::Vector3d Along(double x) {
  return {x, 0, 0};
}

// Jitter delays samples, but the output never decreases on a rising force, except once: the
// play-out time steps back when the delay estimate grows.
TEST(DelayedLinearTest, JitterNeitherStallsNorOvershoots) {
  DelayedLinear shown;
  const double period = 1.0 / 60;
  int next = 0;
  double worst = 0;
  for (int tick = 0; tick < 3000; ++tick) {
    const double now = tick * 0.001;
    const auto arrival = [&](int k) { return k * period + 0.010 + 0.004 * std::sin(1.7 * k); };
    for (; arrival(next) <= now; ++next)
      shown.Add(next * period, arrival(next), Along(next * period));
    if (now > 1) worst = std::max(worst, std::abs(now - shown.At(now).x() - period - 0.014));
  }
  EXPECT_LT(worst, 0.0015);
}

TEST(DelayedLinearTest, IgnoresStampsThatDoNotRise) {
  DelayedLinear shown;
  shown.Add(0, 0, Along(1));
  shown.Add(1, 1, Along(2));
  shown.Add(1, 1.1, Along(7));
  shown.Add(0.5, 1.2, Along(9));
  shown.Add(std::nan(""), 1.3, Along(9));
  EXPECT_EQ(shown.newest().x(), 2);
  EXPECT_EQ(shown.At(1.5).x(), 1.5);
}

}  // namespace
}  // namespace palpate
