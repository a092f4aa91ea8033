#include "slave/vision/dots/ground_ring.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// A ring of 10 to 13 px with noise of two levels for each pixel and `shared` for each of the
// sectors, up and down in turn.
GroundRing Ring(double shared) {
  GroundRing ring;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 2);
  for (int y = -13; y <= 13; ++y) {
    for (int x = -13; x <= 13; ++x) {
      const double r = std::hypot(x, y);
      if (r < 10 || r > 13) continue;
      const int sector = GroundRing::SectorOf(x, y);
      const double alike = sector % 2 == 0 ? shared : -shared;
      ring.Add(sector, x, y, 200 + 0.3 * x + alike + noise(random), true);
    }
  }
  return ring;
}

// Reference: noise of two levels common to a sector plus two levels for each of its 14 pixels gives
// a squared mean of 4 + 4 / 14; independent pixels with the same variance, 8, would give 8 / 14.
TEST(GroundRing, CorrelatedNoiseOfNeighboursIsDetected) {
  GroundRing ring = Ring(2);
  ASSERT_TRUE(ring.Fit());
  EXPECT_GT(ring.unevenness(), 4);
}

}  // namespace
}  // namespace palpate
