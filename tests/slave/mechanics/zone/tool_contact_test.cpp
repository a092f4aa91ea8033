// Rigid tools that press and slide: Coulomb's law, release, work, and the limits without and with
// endless friction.
#include "slave/mechanics/fem/zone/tool_contact.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/zone/fem_zone_model.h"
#include "tests/slave/mechanics/zone/pressed_slab.h"

namespace palpate {
namespace {

using namespace zone_tests;  // NOLINT(google-build-using-namespace): its helpers are for here

constexpr double kRadius = 0.02;  // of the sphere [m]

FemZoneModel::Options Sphere(ContactLaw law, double friction = 0) {
  FemZoneModel::Options options;
  options.contact = law;
  options.friction = friction;
  options.tool = {.shape = RigidTool::Shape::kSphere, .radius = kRadius};
  return options;
}

class ZoneTool : public testing::Test {
 protected:
  ContactResponse Move(FemZoneModel* model, const Vector3d& displacement) {
    contact_.prescribed_O = displacement;
    std::vector<ContactResponse> response(1);
    model->Respond({&contact_, 1}, response);
    EXPECT_NE(response[0].validity, Validity::kFailed) << model->failure();
    return response[0];
  }
  FemZoneModel Model(const FemZoneModel::Options& options) const {
    return {slab_.mesh, slab_.held, kModulus, slab_.nu, options};
  }

  Slab slab_{12, 0.4};
  Contact contact_{.p_O = {0.04, 0.04, 0.04}};
};

// A disc that slides far is held back by mu times its normal force, against its way.
TEST_F(ZoneTool, AFlatToolSlidesUnderCoulombsForce) {
  FemZoneModel::Options options;
  options.contact = ContactLaw::kFriction;
  options.friction = 0.4;
  FemZoneModel model = Model(options);
  contact_.width = 0.018;
  Move(&model, {0, 0, -0.002});
  const Vector3d force = Move(&model, {0.012, 0, -0.002}).force_O;
  EXPECT_LT(force.z(), 0);
  EXPECT_NEAR(force.x(), -0.4 * force.z(), 0.01 * 0.4 * std::abs(force.z()));
  EXPECT_NEAR(force.y(), 0, 0.02 * std::abs(force.z()));
}

// Little friction force: it sticks, and the force is that of endless friction.
TEST_F(ZoneTool, FrictionLiesBetweenFrictionlessAndBonded) {
  FemZoneModel free = Model(Sphere(ContactLaw::kFrictionless)),
               rough = Model(Sphere(ContactLaw::kFriction, 0.3)),
               bonded = Model(Sphere(ContactLaw::kBonded));
  for (FemZoneModel* model : {&free, &rough, &bonded}) Move(model, {0, 0, -0.004});
  const Vector3d way(0.003, 0, -0.004);
  const double none = Move(&free, way).force_O.x(), some = Move(&rough, way).force_O.x(),
               most = Move(&bonded, way).force_O.x();
  EXPECT_LT(std::abs(none), 0.1 * most);
  EXPECT_LT(none, some);
  EXPECT_LT(some, most);
}

TEST_F(ZoneTool, AToolThatLeavesLetsGo) {
  FemZoneModel model = Model(Sphere(ContactLaw::kFriction, 0.5));
  EXPECT_LT(Move(&model, {0.001, 0, -0.004}).force_O.z(), -0.01);
  const ContactResponse away = Move(&model, {0, 0, 0.003});
  EXPECT_EQ(away.force_O, Vector3d::Zero());
  EXPECT_EQ(away.validity, Validity::kValid);
  EXPECT_LT(Move(&model, {0.001, 0, -0.004}).force_O.z(), -0.01);
}

// Round and back again, with and without sliding: the tool does work on the body and never the
// reverse.
TEST_F(ZoneTool, AClosedPathGivesNoEnergy) {
  FemZoneModel model = Model(Sphere(ContactLaw::kFriction, 0.4));
  Vector3d before(0, 0, -0.003), force = Move(&model, before).force_O;
  double work = 0, size = 0;
  constexpr int kSteps = 48;
  for (int k = 1; k <= 2 * kSteps; ++k) {
    const double angle = 2 * std::numbers::pi * k / kSteps;
    const Vector3d now(0.003 * std::sin(angle), 0.003 * (1 - std::cos(angle)),
                       -0.003 - 0.0005 * std::sin(2 * angle));
    const Vector3d next = Move(&model, now).force_O;
    const double step = 0.5 * (force + next).dot(now - before);
    work += step;
    size += std::abs(step);
    if (k == kSteps) work = 0;  // the first round ends where the second begins
    before = now, force = next;
  }
  EXPECT_GT(work, 0.1 * size);
}

// What the whole body as one nonlinear zone gives: the zone's error apart, friction is the same.
TEST_F(ZoneTool, TheForceIsThatOfTheWholeNonlinearBodyWithinItsBound) {
  FemZoneModel zone = Model(Sphere(ContactLaw::kFriction, 0.3));
  FemZoneModel::Options everywhere = Sphere(ContactLaw::kFriction, 0.3);
  everywhere.least_radius = 1;
  FemZoneModel whole = Model(everywhere);
  for (const Vector3d& way : {Vector3d(0, 0, -0.005), Vector3d(0.004, 0.001, -0.005)}) {
    const ContactResponse got = Move(&zone, way), expected = Move(&whole, way);
    const double error = (got.force_O - expected.force_O).norm();
    EXPECT_LE(error, got.force_error);
    EXPECT_LT(error, 0.03 * expected.force_O.norm());
    EXPECT_EQ(expected.force_error < 0.01 * expected.force_O.norm(), true);
  }
}

}  // namespace
}  // namespace palpate
