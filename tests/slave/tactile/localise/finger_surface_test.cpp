#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slave/tactile/localise/electrode_layout.h"

namespace palpate {
namespace {

// Reference: the implicit equations of sphere and cylinder, and the projected point must lie on the
// ray used in the paper: from the centre, or from the axis at the same x. Tolerance: rounding.
TEST(FingerSurfaceTest, ProjectsOnTheSphereInFrontAndOnTheCylinderBehind) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (const double radius : {1e-9, 7e-3, 1e3}) {
    const FingerSurface surface{radius};
    for (int i = 0; i < 1000; ++i) {
      const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
      const Eigen::Vector3d c = 2 * radius * Eigen::Vector3d(x, y, z);
      const auto p = surface.Project(c);
      ASSERT_TRUE(p);
      const Eigen::Vector3d centre(std::min(c.x(), 0.0), 0, 0);
      EXPECT_NEAR((*p - centre).norm() / radius, 1, 1e-14);
      EXPECT_LT((*p - centre).normalized().cross((c - centre).normalized()).norm(), 1e-14);
      EXPECT_GT((*p - centre).dot(c - centre), 0);
      EXPECT_LT((surface.Normal(*p) - (*p - centre).normalized()).norm(), 1e-14);
    }
  }
}

}  // namespace
}  // namespace palpate
