#include "master/haptics/force_chain.h"

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

}  // namespace
}  // namespace palpate
