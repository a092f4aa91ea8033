#include "master/motion/fixture.h"

#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

// A point in a cube of 2 m around the origin.
Vector3d AnyPoint(std::mt19937_64* random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  return {uniform(*random), uniform(*random), uniform(*random)};
}

Fixture AnyFixture(std::mt19937_64* random) {
  Fixture fixture;
  fixture.kind = static_cast<Fixture::Kind>((*random)() % 5);
  fixture.point = AnyPoint(random);
  fixture.direction = AnyPoint(random).normalized();
  std::uniform_real_distribution<double> size(0.05, 1);
  fixture.size = size(*random);
  if (fixture.kind == Fixture::Kind::kBox) {
    const Vector3d other = AnyPoint(random);
    fixture.direction = fixture.point.cwiseMax(other);
    fixture.point = fixture.point.cwiseMin(other);
  }
  return fixture;
}

// Whether `p` lies in the region, by the definition of each kind. `slack` [m].
bool IsInside(const Fixture& fixture, const Vector3d& p, double slack) {
  const Vector3d q = p - fixture.point;
  const double along = q.dot(fixture.direction);
  switch (fixture.kind) {
    case Fixture::Kind::kPlane:
      return along >= -slack;
    case Fixture::Kind::kLine:
      return q.cross(fixture.direction).norm() <= fixture.size + slack;
    case Fixture::Kind::kSphere:
      return q.norm() <= fixture.size + slack;
    case Fixture::Kind::kCone:
      return q.cross(fixture.direction).norm() <=
             along * std::tan(fixture.size) + slack / std::cos(fixture.size);
    case Fixture::Kind::kBox:
      return (q.array() >= -slack).all() && ((fixture.direction - p).array() >= -slack).all();
  }
  return false;
}

// Reference: none of 200 random points of each region is nearer. The nearest point itself lies in
// the region.
TEST(FixtureTest, TheNearestPointIsInTheRegionAndNoOtherIsNearer) {
  std::mt19937_64 random(3);
  int outside = 0;
  for (int round = 0; round < 500; ++round) {
    const Fixture fixture = AnyFixture(&random);
    const Vector3d p = AnyPoint(&random), nearest = fixture.Nearest(p);
    ASSERT_TRUE(IsInside(fixture, nearest, 1e-12)) << static_cast<int>(fixture.kind);
    if (IsInside(fixture, p, 0)) ASSERT_LT((nearest - p).norm(), 1e-14);
    outside += IsInside(fixture, p, 0) ? 0 : 1;
    for (int i = 0; i < 200; ++i) {
      const Vector3d other = AnyPoint(&random);
      if (!IsInside(fixture, other, 0)) continue;
      ASSERT_GE((other - p).norm(), (nearest - p).norm() - 1e-12);
    }
  }
  EXPECT_GT(outside, 200);
}

// The energy of a sampled spring: the force is held while the device moves to its next position.
// Reference: on a closed path the device's physical damping b = K T / 2 (Colgate and Schenkel 1994)
// dissipates at least what the spring releases, for every path; positions jump at random. The
// tolerance is rounding of the sum.
TEST(FixturePropertyTest, NoClosedPathGainsEnergy) {
  std::mt19937_64 random(4);
  int pulled = 0;
  double closest = -std::numeric_limits<double>::infinity();  // gain by the energy of the path
  for (int round = 0; round < 2000; ++round) {
    const Fixture fixture = AnyFixture(&random);
    FixtureSpring spring(fixture);
    const double K = 1, kDampedPerStep = K / 2;  // b |dp|^2 / T with b = K T / 2
    const Vector3d begin = AnyPoint(&random);
    spring.Begin(begin);
    Vector3d p = begin;
    double gained = 0, size = 0;
    const bool jumps = round % 2 == 0;
    for (int i = 0; i <= 100; ++i) {
      Vector3d next = jumps ? AnyPoint(&random) : Vector3d(p + 0.05 * AnyPoint(&random));
      if (i == 100) next = begin;
      const Vector3d f = K * spring.Pull(p), dp = next - p;
      gained += f.dot(dp) - kDampedPerStep * dp.squaredNorm();
      size += std::abs(f.dot(dp)) + kDampedPerStep * dp.squaredNorm();
      pulled += f.norm() > 0 ? 1 : 0;
      p = next;
    }
    ASSERT_LE(gained, 1e-13 * size) << round;
    closest = std::max(closest, gained / size);
  }
  EXPECT_GT(pulled, 20000) << "the test did not exercise the springs";
  EXPECT_LT(closest, 0);
}

TEST(FixtureTest, DoesNotPullInAToolThatBeginsOutside) {
  Fixture sphere{Fixture::Kind::kSphere, {0, 0, 0}, {0, 0, 1}, 0.01};
  FixtureSpring spring(sphere);
  spring.Begin({0.03, 0, 0});
  EXPECT_TRUE(spring.Pull({0.03, 0, 0}).isZero(0));
  EXPECT_NEAR(spring.Pull({0.035, 0, 0}).x(), -0.005, 1e-15) << "but it may not go farther";
  EXPECT_TRUE(spring.Pull({0.02, 0, 0}).isZero(0));
  EXPECT_NEAR(spring.Pull({0.03, 0, 0}).x(), -0.01, 1e-15) << "nor back";
  EXPECT_TRUE(spring.Pull({0.005, 0, 0}).isZero(0));
  EXPECT_NEAR(spring.Pull({0, 0.03, 0}).y(), -0.02, 1e-15);
}

TEST(FixtureTest, ReadsItsText) {
  const Fixture cone = Fixture::Parse("cone:1,2,3:0,0,2:30");
  EXPECT_EQ(cone.kind, Fixture::Kind::kCone);
  EXPECT_LT((cone.point - Vector3d(1e-3, 2e-3, 3e-3)).norm(), 1e-18);
  EXPECT_EQ(cone.direction, Vector3d(0, 0, 1));
  EXPECT_NEAR(std::tan(cone.size), 1 / std::sqrt(3.0), 1e-15);
  EXPECT_EQ(Fixture::Parse("line:0,0,0:1,0,0").size, 0);
  EXPECT_NEAR(Fixture::Parse("line:0,0,0:1,0,0:2").size, 2e-3, 1e-18);
  EXPECT_EQ(Fixture::Parse("plane:0,0,0:0,-3,0").direction, Vector3d(0, -1, 0));
  const Vector3d upper = Fixture::ParseBox("5,-1,0:1,2,3").direction;
  EXPECT_LT((upper - Vector3d(5e-3, 2e-3, 3e-3)).norm(), 1e-18);
}

TEST(FixtureTest, RejectsOtherText) {
  for (const char* text :
       {"", "plane", "plane:0,0,0", "plane:0,0,0:0,0,0", "plane:0,0,0:0,0,1:5", "cone:0,0,0:0,0,1",
        "cone:0,0,0:0,0,1:90", "cone:0,0,0:0,0,1:0", "sphere:0,0,0:-1", "sphere:0,0,0",
        "sphere:0,0:1", "line:0,0,nan:0,0,1", "box:0,0,0:1,1,1", "sphere:0,0,0:1:2"}) {
    try {
      (void)Fixture::Parse(text);
      ADD_FAILURE() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("expected plane:X,Y,Z:NX,NY,NZ")) << text;
    }
  }
  EXPECT_THROW((void)Fixture::ParseBox("0,0,0"), std::invalid_argument);
  EXPECT_THROW((void)Fixture::ParseBox("0,0,0:1,x,1"), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
