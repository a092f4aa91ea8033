#include "slave/tactile/localise/direction_mean.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kFingerRadius = 7e-3;

Intensities Only(std::initializer_list<std::pair<std::size_t, double>> active) {
  Intensities intensities;
  for (const auto& [electrode, intensity] : active) intensities.Set(electrode, intensity);
  return intensities;
}

class DirectionMeanTest : public ::testing::Test {
 protected:
  ElectrodeLayout layout_ = SimulatedLayout(kFingerRadius);
  DirectionMean mean_{layout_, kFingerRadius};
};

// Laws: the unit of intensity does not matter; mirrored intensities give the mirrored contact.
TEST_F(DirectionMeanTest, DoesNotDependOnUnitOrSide) {
  ElectrodeLayout mirrored = layout_;
  for (Vector3d& p : mirrored.p_F) p.y() = -p.y();
  const DirectionMean other(mirrored, kFingerRadius);
  const Intensities one = Only({{0, 1.0}, {4, 2.0}, {9, 5.0}});
  const Intensities million = Only({{0, 1e6}, {4, 2e6}, {9, 5e6}});
  const Vector3d p = mean_.PlaceOf(*mean_.Mean(one)), q = other.PlaceOf(*other.Mean(one));
  EXPECT_LT((p - mean_.PlaceOf(*mean_.Mean(million))).norm(), 1e-16);
  EXPECT_LT((p - Vector3d(q.x(), -q.y(), q.z())).norm(), 1e-16);
}

// Law: every place is on the surface, and similar normals give nearby places, from the cylinder's
// back to the tip. Tolerance: over the 8 degrees of blending the place moves from the mean on the
// axis, here 10 mm behind, to the pad: 10 mm / 8 degrees is 1.3 mm per degree.
TEST_F(DirectionMeanTest, RunsOverTheSurfaceWithoutLeaps) {
  const FingerSurface surface{kFingerRadius};
  const double degree = std::numbers::pi / 180;
  std::optional<Vector3d> last;
  for (double elevation = -20; elevation <= 90; elevation += 0.01) {
    const double e = elevation * degree;
    const Vector3d p = mean_.PlaceOf({{std::sin(e), 0.6 * std::cos(e), -0.8 * std::cos(e)}, -0.01});
    const auto on_surface = surface.Project(p);
    ASSERT_TRUE(on_surface);
    EXPECT_LT((*on_surface - p).norm(), 1e-12);
    if (last) {
      EXPECT_LT((p - *last).norm(), 0.03e-3) << elevation;
    }
    last = p;
  }
  EXPECT_LT((*last - Vector3d(kFingerRadius, 0, 0)).norm(), 1e-5);
  EXPECT_EQ(mean_.PlaceOf({{1, 0, 0}, 0}), Vector3d(kFingerRadius, 0, 0));
  EXPECT_LT((mean_.PlaceOf({{0, 0, -1}, -0.01}) - Vector3d(-0.01, 0, -kFingerRadius)).norm(),
            1e-16);
}

}  // namespace
}  // namespace palpate
