#include "shared/patch/patch_contact.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/shared/patch/patches.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kK = 500;  // [N/m]

PatchContact On(const SurfacePatch& patch) {
  PatchContact contact;
  contact.Take(patch, Law(patch, 1), 0, 0);
  return contact;
}
// Moves down at `x` to `depth` below y = 0, step by step.
Vector3d Press(PatchContact* contact, double x, double depth) {
  Vector3d force(0, 0, 0);
  for (int i = 0; i <= 100; ++i)
    force = contact->ForceAt({x, 1e-3 - i * (depth + 1e-3) / 100, 0}, 1, 1);
  return force;
}

// Reference: Hooke's law. Tolerance: single precision of the compliance, 1e-7.
TEST(PatchContactTest, OneNodeIsASpringFromWhereTheTipCameIn) {
  PatchContact contact = On(Plane(kK));
  EXPECT_TRUE(Press(&contact, 0.003, -0.5e-3).isZero(0));
  EXPECT_NEAR(Press(&contact, 0.003, 2e-3).y(), kK * 2e-3, 1e-4);
  const Vector3d sideways = contact.ForceAt({0.004, -2e-3, 0}, 1, 1);
  EXPECT_NEAR(sideways.x(), -kK * 1e-3, 1e-4);
  EXPECT_NEAR(contact.depth(), 2e-3, 1e-9);
}

// Reference: the law's definition, linear between its points and constant beyond.
TEST(PatchContactTest, TheLawScalesTheForceByDepth) {
  const SurfacePatch plane = Plane(kK);
  PatchLaw law = Law(plane, 1);
  for (std::size_t i = 0; i < law.ratios.size(); ++i)
    law.ratios[i] = 1 + static_cast<double>(i) / 15;
  PatchContact contact;
  contact.Take(plane, law, 0, 0);
  for (const double depth : {1e-3, 4.2e-3, 10e-3, 15e-3}) {
    const double ratio = 1 + std::min(depth / plane.full_depth, 1.0);
    EXPECT_NEAR(Press(&contact, 0, depth).y(), ratio * kK * depth, 1e-4) << depth;
    contact.EndContact();
  }
}

TEST(PatchContactTest, OutsideThePatchThereIsNoForce) {
  PatchContact contact = On(Roof(kK, 0, 3));
  EXPECT_TRUE(Press(&contact, 0.03, 2e-3).isZero(0));
  EXPECT_FALSE(contact.serves());
  contact.EndContact();
  EXPECT_GT(Press(&contact, 0.01, 2e-3).y(), 0);
  EXPECT_TRUE(contact.serves());
}

// Reference: the mean of the vertices' compliances by their weights.
TEST(PatchContactTest, BetweenTwoNodesTheCompliancesAreMixed) {
  SurfacePatch roof = Roof(kK, 0, 3);
  roof.compliance.block<3, 3>(0, 0) *= 3;
  PatchContact contact = On(roof);
  EXPECT_NEAR(Press(&contact, 0.01, 1e-3).y(), kK / 2 * 1e-3, 1e-5);
}

// Reference: geometry. The force is along the normal of the face below the tool, whatever the
// tool's path was.
TEST(PatchContactTest, WithoutFrictionTheForceFollowsTheSurface) {
  PatchContact contact = On(Roof(kK, 0, 1, 0.2));
  Press(&contact, 0.01, 4e-3);
  for (double x = 0.01; x > -0.01; x -= 2e-4) {
    const Vector3d force = contact.ForceAt({x, -4e-3, 0}, 1, 1);
    if (std::abs(x) < 2e-3) continue;  // at the ridge both faces are as near
    EXPECT_NEAR(force.x() / force.y(), x > 0 ? 0.2 : -0.2, 1e-6) << x;
  }
}

// Reference: Coulomb.
TEST(PatchContactTest, FrictionLimitsTheForceAlongTheSurfaceAndDragsTheAnchor) {
  const SurfacePatch plane = Plane(kK);
  PatchLaw law = Law(plane, 1);
  law.friction = 0.3;
  PatchContact contact;
  contact.Take(plane, law, 0, 0);
  Press(&contact, 0, 2e-3);
  for (double x = 0; x < 5e-3; x += 1e-5) {
    const Vector3d force = contact.ForceAt({x, -2e-3, 0}, 1, 1);
    ASSERT_LE(std::abs(force.x()), 0.3 * force.y() + 1e-9);
  }
  EXPECT_NEAR(contact.ForceAt({5e-3, -2e-3, 0}, 1, 1).x(), -0.3 * kK * 2e-3, 1e-3);
  EXPECT_GT(contact.ForceAt({4e-3, -2e-3, 0}, 1, 1).x(), 0) << "the anchor was not dragged along";
}

SurfacePatch TwoTools(double coupling) {
  SurfacePatch roof = Roof(kK, coupling, 3);
  roof.tool_count = 2;
  roof.tools[1].centre = {-0.02, -1e-3, 0};  // above the midpoint, 1 mm deeper
  return roof;
}

// Reference: the equations of both contacts, solved by LU. Each sweep reduces the error by the
// square of the coupling (0.5^24 in total) and continues from the previous tick.
TEST(PatchContactTest, TwoToolsShareWhatTheyPress) {
  const double coupling = 0.5;
  PatchContact contact = On(TwoTools(coupling));
  const double depth = 3e-3;
  const Vector3d force = Press(&contact, 0.02 * (1 - 1e-6), depth);
  Eigen::Matrix2d C;
  C << 1, coupling, coupling, 1;
  const Eigen::Vector2d forces = (C / kK).inverse() * Eigen::Vector2d(depth, depth + 1e-3);
  EXPECT_NEAR(force.y(), forces[0], 1e-4);
}

// Reference: complementarity. The other tool does not touch the surface that the deeper tool has
// moved away from it.
TEST(PatchContactTest, AToolWhoseSurfaceIsPressedAwayByAnotherHasNoForce) {
  PatchContact contact = On(TwoTools(0.9));
  EXPECT_TRUE(Press(&contact, 0.02 * (1 - 1e-6), 0.5e-3).isZero(0));
}

TEST(PatchContactTest, DoesNotAllocateAndReturnsFiniteForces) {
  PatchRender render;
  const SurfacePatch one = TwoTools(0.5);
  SurfacePatch other = one;
  other.epoch = 2;
  PatchLaw last = Law(other, 1);
  const long before = AllocationCount();
  bool finite = true;
  for (int i = 0; i < 2000; ++i) {
    const double t = i * 1e-3;
    if (i == 10) render.Take(one, Law(one, 1), t, t);
    if (i == 500) render.Take(one, Law(one, 2, 1.4), t, t);
    if (i == 1000) render.Take(other, last, t, t);
    Vector3d p(0.015, 1e-3 - 3e-3 * std::sin(0.01 * i), 0);
    if (i % 97 == 0) p.x() = std::numeric_limits<double>::quiet_NaN();
    if (i % 101 == 0) p.y() = std::numeric_limits<double>::infinity();
    finite = finite && render.ForceAt(p, t, t).allFinite();
  }
  EXPECT_EQ(AllocationCount(), before);
  EXPECT_TRUE(finite);
}

// Reference: no step of the force. Limit per tick: a spring K moved by 20 um, plus the change of a
// blend over 30 ms.
TEST(PatchContactTest, AnotherPatchOrLawComesWithoutAStep) {
  PatchRender render;
  const SurfacePatch one = Plane(kK);
  SurfacePatch other = Plane(2 * kK);
  other.epoch = 2;
  render.Take(one, Law(one, 1), 0, 0);
  Vector3d last(0, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const double t = i * 1e-3;
    if (i == 400) render.Take(one, Law(one, 2, 1.5), t, t);
    if (i == 700) render.Take(other, Law(other, 1), t, t);
    const Vector3d force = render.ForceAt({0, std::max(-2e-3, 1e-3 - 2e-5 * i), 0}, t, t);
    ASSERT_LT((force - last).norm(), 0.045) << i;
    last = force;
  }
  EXPECT_NEAR(last.y(), 2 * kK * 2e-3, 1e-3);
}

// Reference: uniform motion. The law is of the surface's position 0.2 s ago and of its velocity.
TEST(PatchContactTest, ASurfaceThatMovesIsCarriedOn) {
  const SurfacePatch plane = Plane(kK);
  PatchLaw law = Law(plane, 1);
  law.offset = {0, 1e-3, 0};
  law.velocity = {0, 0.005, 0};
  law.velocity_error = 1e-4;
  PatchContact contact;
  contact.Take(plane, law, 0.8, 1);
  contact.ForceAt({0, 0.01, 0}, 1, 1);
  const double surface = 1e-3 + 0.2 * 0.005;
  EXPECT_NEAR(contact.ForceAt({0, surface - 1e-3, 0}, 1, 1).y(), kK * 1e-3, 1e-3);
}

// Reference: a passive spring. On any closed path that begins and ends outside, it returns no more
// energy than it received.
TEST(PatchContactTest, AClosedPathDeliversNoEnergy) {
  for (const int directions : {1, 3}) {
    PatchContact contact = On(Roof(kK, 0, directions, 0.1));
    Vector3d p(0.012, 1e-3, 0), force = contact.ForceAt(p, 1, 1);
    double given = 0;
    for (int i = 1; i <= 4000; ++i) {
      const double turn = 2 * 3.14159265358979 * i / 4000;
      const Vector3d next(0.012 - 0.01 * std::sin(turn), 1e-3 - 4e-3 * (1 - std::cos(turn)), 0);
      const Vector3d after = contact.ForceAt(next, 1, 1);
      given += 0.5 * (force + after).dot(next - p);
      p = next;
      force = after;
    }
    EXPECT_LT(given, 2e-6) << directions;
  }
}

}  // namespace
}  // namespace palpate
