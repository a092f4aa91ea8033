#include "master/haptics/force_chain.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(LimitForceTest, KeepsTheDirectionAndTheLimit) {
  Reasons reasons;
  EXPECT_EQ(LimitForce({0, 3, 0}, 3.3, &reasons), Eigen::Vector3d(0, 3, 0));
  EXPECT_TRUE(reasons.empty());
  const Eigen::Vector3d limited = LimitForce({3, 4, 0}, 2.5, &reasons);
  EXPECT_NEAR((limited - Eigen::Vector3d(1.5, 2, 0)).norm(), 0, 1e-15);
  EXPECT_TRUE(reasons.Has(Reason::kClamped));
}

TEST(LimitForceTest, HugeAndImpossibleForcesStayFiniteAndWithin) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {1e300, -1e308, inf, -inf, std::nan("")}) {
    Reasons reasons;
    const Eigen::Vector3d limited = LimitForce({bad, bad, 1}, 3.3, &reasons);
    EXPECT_TRUE(limited.allFinite()) << bad;
    EXPECT_LE(limited.norm(), 3.3 * (1 + 1e-12)) << bad;
    EXPECT_FALSE(reasons.empty()) << bad;
    if (std::isfinite(bad)) {
      EXPECT_NEAR(limited.norm(), 3.3, 1e-12) << bad;
    }
  }
}

}  // namespace
}  // namespace palpate
