// Forces of a zone against the full models of the same mesh.
#include "slave/mechanics/fem/zone/zone_solver.h"

#include <gtest/gtest.h>

#include "tests/slave/mechanics/zone/pressed_slab.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using namespace zone_tests;  // NOLINT(google-build-using-namespace): its helpers are for here

constexpr double kWidth = 0.02;  // of the disc [m]

Vector3d FullForce(SolidModel& full, const Vector3d& p_O, const Vector3d& displacement) {
  Contact contact;
  contact.p_O = p_O;
  contact.width = kWidth;
  contact.prescribed_O = displacement;
  std::vector<ContactResponse> responses(1);
  full.Respond(std::span(&contact, 1), responses);
  EXPECT_NE(responses[0].validity, Validity::kFailed) << full.failure();
  return responses[0].force_O;
}

Vector3d ZoneForce(const Slab& slab, const PressedZone& pressed, const Vector3d& displacement) {
  ZoneTangent tangent(*pressed.body, pressed.contact);
  ZoneSolver solver(*pressed.body, pressed.contact);
  const VectorXd target = Alike(slab, pressed.contact, displacement);
  for (int k = 0; k < 6; ++k) {
    EXPECT_TRUE(tangent.Compute(solver.u()));
    solver.Step(tangent, target);
  }
  EXPECT_LT(solver.last_change().norm(), 1e-9 * solver.Force().norm());
  return slab.force_unit() * solver.Force();
}

// A tiny press is linear everywhere: the condensation is exact, whatever the zone.
TEST(ZoneSolver, TinyPressesAreThoseOfTheLinearBody) {
  const Slab slab(10, 0.4);
  LinearRest rest(slab.mesh, slab.held, slab.nu);
  SolidModel full = slab.Full(FemOptions::Law::kLinear);
  const Vector3d p_O(0.03, 0.045, 0.04), displacement(1e-9, -2e-9, -4e-9);
  for (const double radius : {0.0, 0.015, 0.025}) {
    const PressedZone pressed(slab, rest, p_O, kWidth, radius);
    const Vector3d expected = FullForce(full, p_O, displacement);
    EXPECT_LT((ZoneForce(slab, pressed, displacement) - expected).norm(), 1e-6 * expected.norm());
  }
}

// A press by 30 % of the width, oblique, against the full nonlinear model: within the 3 % that the
// method promises for zones as wide as the disc in every direction, and closer for wider ones.
TEST(ZoneSolver, DeepPressesAreThoseOfTheNonlinearBody) {
  const Slab slab(10, 0.4);
  LinearRest rest(slab.mesh, slab.held, slab.nu);
  SolidModel full = slab.Full(FemOptions::Law::kNeoHookean);
  for (const Vector3d& p_O : {Vector3d(0.04, 0.04, 0.04), Vector3d(0.021, 0.034, 0.04)}) {
    const Vector3d displacement(0.1 * kWidth, -0.05 * kWidth, -0.3 * kWidth);
    const Vector3d expected = FullForce(full, p_O, displacement);
    const auto error = [&](double radius) {
      const PressedZone pressed(slab, rest, p_O, kWidth, radius);
      return (ZoneForce(slab, pressed, displacement) - expected).norm() / expected.norm();
    };
    const double near = error(kWidth), wide = error(1.5 * kWidth);
    EXPECT_LT(near, 0.03);
    EXPECT_LT(wide, 0.6 * near);
  }
}

// Many small updates with a tangent that is never refreshed stay near the converged answers, and
// take nothing from the heap.
TEST(ZoneSolver, UpdatesWithAnOldTangentFollowAPress) {
  const Slab slab(10, 0.4);
  LinearRest rest(slab.mesh, slab.held, slab.nu);
  const PressedZone pressed(slab, rest, {0.04, 0.04, 0.04}, kWidth, kWidth);
  ZoneTangent tangent(*pressed.body, pressed.contact);
  ZoneSolver solver(*pressed.body, pressed.contact);
  ASSERT_TRUE(tangent.Compute(solver.u()));
  const Vector3d deepest(0.1 * kWidth, 0, -0.3 * kWidth);
  std::vector<VectorXd> targets;
  for (int k = 1; k <= 100; ++k) {
    targets.push_back(Alike(slab, pressed.contact, 0.01 * k * deepest));
  }
  solver.Step(tangent, targets[0]);
  const long before = AllocationCount();
  for (const VectorXd& target : targets) solver.Step(tangent, target);
  EXPECT_EQ(AllocationCount(), before);
  const Vector3d converged = ZoneForce(slab, pressed, deepest);
  EXPECT_LT((slab.force_unit() * solver.Force() - converged).norm(), 0.01 * converged.norm());
}

}  // namespace
}  // namespace palpate
