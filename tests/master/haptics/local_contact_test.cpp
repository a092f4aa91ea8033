#include <cmath>

#include <gtest/gtest.h>

#include "master/haptics/renderer.h"

namespace palpate {
namespace {

LocalModel Wall(double K, double y, std::uint32_t revision) {
  LocalModel model;
  model.reference = {0, y, 0};
  model.stiffness(1, 1) = K;
  model.valid_radius = 0.01;
  model.revision = revision;
  return model;
}

constexpr double kLater = 1.0;  // long after any blend [s]

struct LocalContactTest : testing::Test {
  LocalContact contact;
};

// Reference: f = f_r + K (x_r - p), calculated by hand for a full matrix K and an oblique plane.
TEST_F(LocalContactTest, IsTheLinearLawInsideAndZeroOutside) {
  LocalModel model;
  model.reference = {0.001, 0.002, 0};
  model.normal = Eigen::Vector3d(3, 4, 0) / 5;
  model.force = {0.5, 0, 0};
  model.stiffness << 100, 20, 0, 20, 300, 0, 0, 0, 50;
  model.revision = 1;
  model.in_contact = true;
  contact.Take(model, 0);
  const Eigen::Vector3d inside = contact.ForceAt({0, 0, 0.001}, kLater);
  EXPECT_NEAR((inside - Eigen::Vector3d(0.64, 0.62, -0.05)).norm(), 0, 1e-15);
  EXPECT_EQ(contact.ForceAt({0.01, 0, 0}, kLater).norm(), 0);
  EXPECT_EQ(contact.ForceAt({std::nan(""), 0, 0}, kLater).norm(), 0);
}

// Reference: the tangent to F = c d^3 at d = 3 mm, which meets zero at 2 mm.
TEST_F(LocalContactTest, TheTangentToAStiffeningLawNeverPulls) {
  constexpr double c = 1e8, d = 0.003;  // [N/m^3], [m]
  LocalModel model = Wall(3 * c * d * d, 0, 1);
  model.force = {0, c * d * d * d - 3 * c * d * d * d, 0};
  model.in_contact = true;
  contact.Take(model, 0);
  EXPECT_NEAR(contact.ForceAt({0, -d, 0}, kLater).y(), c * d * d * d, 1e-12);
  for (const double depth : {0.0001, 0.001, 0.0019999}) {
    EXPECT_EQ(contact.ForceAt({0, -depth, 0}, kLater).norm(), 0) << depth;
  }
  EXPECT_GT(contact.ForceAt({0, -0.0021, 0}, kLater).y(), 0);
}

// An oblique plane through the origin, bonded: K couples all directions.
LocalModel BondedWall(const Eigen::Vector3d& reference, bool in_contact, std::uint32_t revision) {
  LocalModel model;
  model.normal = Eigen::Vector3d(3, 4, 0) / 5;
  model.reference = reference;
  model.stiffness << 400, 30, 0, 30, 300, 0, 0, 0, 50;
  model.valid_radius = 0.01;
  model.revision = revision;
  model.in_contact = in_contact;
  return model;
}

const Eigen::Vector3d kAlong = Eigen::Vector3d(4, -3, 0) / 5,
                      kInto = Eigen::Vector3d(-3, -4, 0) / 5;

// The slave's contact point is 2 mm behind a device that slid along the surface before it pressed.
// Reference: the force of a contact that began directly under the device: K d, where d is the
// displacement since then; it is zero at the surface.
TEST_F(LocalContactTest, TheContactBeginsWhereTheDevicePassesTheSurface) {
  contact.Take(BondedWall({0, 0, 0}, false, 1), 0);
  const Eigen::Vector3d crossing = 0.002 * kAlong;
  EXPECT_EQ(contact.ForceAt(crossing - 1e-6 * kInto, kLater).norm(), 0);
  EXPECT_LT(contact.ForceAt(crossing + 1e-9 * kInto, kLater).norm(), 1e-6);
  const Eigen::Vector3d way = 0.001 * kInto + 0.0005 * kAlong;
  const Eigen::Vector3d expected = BondedWall({0, 0, 0}, false, 1).stiffness * -way;
  EXPECT_LT((contact.ForceAt(crossing + way, kLater) - expected).norm(), 1e-6);
  // Its contact point keeps following; this has no effect.
  contact.Take(BondedWall(0.0015 * kAlong, false, 2), kLater);
  for (const double later : {0.0, 0.01, 0.05}) {
    EXPECT_LT((contact.ForceAt(crossing + way, kLater + later) - expected).norm(), 1e-6) << later;
  }
  // The surface is found at another place: the model changes over to the slave's value without a
  // step.
  contact.Take(BondedWall(0.0019 * kAlong, true, 3), 2 * kLater);
  EXPECT_LT((contact.ForceAt(crossing + way, 2 * kLater) - expected).norm(), 1e-6);
  const Eigen::Vector3d bonded =
      expected - 1e-4 * BondedWall({0, 0, 0}, true, 3).stiffness * kAlong;
  EXPECT_LT((contact.ForceAt(crossing + way, 2 * kLater + 0.031) - bonded).norm(), 1e-6);
  // Its late "no contact" with a new contact point does not change the rendered force.
  contact.Take(BondedWall(0.0025 * kAlong, false, 4), 3 * kLater);
  EXPECT_LT((contact.ForceAt(crossing + way, 3 * kLater + 0.05) - bonded).norm(), 1e-6);
  // Leaving the surface and touching it again makes a new contact.
  EXPECT_EQ(contact.ForceAt({0.001, 0.001, 0}, 4 * kLater).norm(), 0);
  EXPECT_LT(contact.ForceAt(-0.003 * kAlong + 1e-9 * kInto, 4 * kLater).norm(), 1e-6);
}

// Late states with "no contact", or without a model, have no effect.
TEST_F(LocalContactTest, NeverDropsThePlaneForALateWord) {
  LocalModel model = Wall(500, 0, 1);
  model.in_contact = true;
  contact.Take(model, 0);
  const double before = contact.ForceAt({0, -0.002, 0}, kLater).y();
  model.in_contact = false;
  contact.Take(model, kLater);
  contact.Take(LocalModel(), kLater);
  EXPECT_EQ(contact.ForceAt({0, -0.002, 0}, kLater).y(), before);
  EXPECT_EQ(before, 1.0);
}

// Reference: the blend is linear in time, so half way the spring is K = 750 N/m from 0.5 mm.
TEST_F(LocalContactTest, BlendsPlaneAndStiffnessOverThirtyMilliseconds) {
  contact.Take(Wall(500, 0, 1), 0);
  contact.Take(Wall(1000, 0.001, 2), kLater);
  const Eigen::Vector3d p(0, -0.002, 0);
  EXPECT_NEAR(contact.ForceAt(p, kLater).y(), 1.0, 1e-12);
  EXPECT_NEAR(contact.ForceAt(p, kLater + 0.015).y(), 750 * 0.0025, 1e-12);
  EXPECT_TRUE(contact.IsBlending(kLater + 0.029));
  EXPECT_FALSE(contact.IsBlending(kLater + 0.031));
  EXPECT_NEAR(contact.ForceAt(p, kLater + 0.031).y(), 3.0, 1e-12);
}

// A change during a change starts from the rendered force, and the surface never pulls.
TEST_F(LocalContactTest, ChangesUponChangesAreContinuousAndNeverPull) {
  contact.Take(Wall(500, 0, 1), 0);
  double last = contact.ForceAt({0, -0.002, 0}, kLater).y();
  std::uint32_t revision = 1;
  for (int tick = 0; tick < 300; ++tick) {
    const double now = kLater + tick * 0.001;
    if (tick % 10 == 0) {
      ++revision;
      contact.Take(Wall(revision % 2 != 0 ? 500 : 1500, revision % 2 != 0 ? 0 : -0.001, revision),
                   now);
    }
    const double force = contact.ForceAt({0, -0.002, 0}, now).y();
    // 1000 N/m and 1 mm in 30 ms at 2 mm depth: at most (2 + 1.5) / 30 N per tick.
    EXPECT_LT(std::abs(force - last), 0.12) << tick;
    for (const double y : {0.0005, 0.0, -0.0003, -0.0007, -0.001, -0.0015}) {
      EXPECT_GE(contact.ForceAt({0, y, 0}, now).y(), 0) << "at " << y;
    }
    last = force;
  }
}

// Reference: calculated by hand. Eigenvalues 3000 and -100 along two perpendicular directions
// become 2000 and 0; the skew part is removed; a valid spring is returned unchanged, bit by bit.
TEST(NearestSpringTest, IsSymmetricAndWithinZeroAndTheBound) {
  const Eigen::Vector3d a = Eigen::Vector3d(1, 2, 2) / 3, b = Eigen::Vector3d(2, 1, -2) / 3;
  const Eigen::Matrix3d wild = 3000 * a * a.transpose() - 100 * b * b.transpose();
  Eigen::Matrix3d skew = Eigen::Matrix3d::Zero();
  skew(0, 1) = 5000;
  skew(1, 0) = -5000;
  const Eigen::Matrix3d expected = 2000 * a * a.transpose();
  EXPECT_LT((NearestSpring(wild + skew, 2000) - expected).norm(), 1e-9);
  Eigen::Matrix3d spring = Eigen::Matrix3d::Zero();
  spring << 100, 20, 0, 20, 300, 0, 0, 0, 0;
  EXPECT_EQ(NearestSpring(spring, 2000), spring);
  EXPECT_TRUE(NearestSpring(1e12 * Eigen::Matrix3d::Ones(), 2000).allFinite());
}

}  // namespace
}  // namespace palpate
