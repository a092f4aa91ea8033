#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slave/tactile/localise/electrode_layout.h"

namespace palpate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Reference: the implicit equations of sphere and cylinder, and that the projected point lies on
// the ray the paper takes: from the centre, or from the axis at the same x. Tolerance: rounding.
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

TEST(FingerSurfaceTest, HasNoProjectionWhereThereIsNoDirection) {
  const FingerSurface surface;
  EXPECT_FALSE(surface.Project({0, 0, 0}));
  EXPECT_FALSE(surface.Project({-3e-3, 0, 0}));
  EXPECT_FALSE(surface.Project({-3e-3, 1e-19, 0}));  // a direction out of rounding is none
  EXPECT_FALSE(surface.Project({kNan, 0, 1e-3}));
  EXPECT_FALSE(surface.Project({0, kInfinity, 0}));
  EXPECT_EQ(surface.Project(Eigen::Vector3d(1e-3, 0, 0)), Eigen::Vector3d(surface.radius, 0, 0));
}

}  // namespace
}  // namespace palpate
