#include "slave/mechanics/plate/pressed_places.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/mechanics/plate/presses.h"

namespace palpate::plate {
namespace {

using Eigen::Vector2d;
using plates::Loaded;
using plates::Moved;

constexpr double kPlateRadius = 0.04, kPlateThickness = 5e-4, kYoung = 1e6, kPoisson = 0.45;

Contact Rigid(Contact contact) {
  contact.is_rigid = true;
  return contact;
}

double Rigidity() {
  return kYoung * std::pow(kPlateThickness, 3) / 12 / (1 - kPoisson * kPoisson);
}

// Places of a face on a plate, their compliance by the Green's function.
struct OnPlate {
  explicit OnPlate(const Disc& disc) {
    AppendPlaces(disc, Face::kRigid, true, &places);
    const auto count = static_cast<Eigen::Index>(places.size());
    compliance.resize(count, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      for (Eigen::Index j = 0; j < count; ++j) {
        compliance(i, j) = Deflection(places[static_cast<std::size_t>(j)],
                                      places[static_cast<std::size_t>(i)].disc.centre);
      }
    }
    pressed.Add({0, count, true, false});
    loaded.Add({0, count, true, true});
    free.setZero(count);
    forces.setZero(count);
  }
  std::vector<PressedPlace> places;
  Eigen::MatrixXd compliance;
  PressedPlaces pressed, loaded;
  Eigen::VectorXd free, forces;
};

// Laws of contact without adhesion: no place pulls, none is inside the tool, and there is no gap
// where there is a force. A tool that pulls upwards obeys the same laws with all signs reversed.
TEST(PressedPlaces, NoneOfARigidFacePullsOrIsInsideIt) {
  for (const double place : {0.0, 0.2, 0.5, 0.7}) {
    for (const double depth : {0.01, -0.01}) {
      OnPlate on({{place, 0}, 0.2});
      ASSERT_TRUE(on.pressed.Solve(on.compliance, on.free, {&depth, 1}, &on.forces));
      const Eigen::VectorXd gaps = (on.compliance * on.forces).array() / depth - 1;
      const Eigen::VectorXd forces = on.forces / depth;
      EXPECT_GE(forces.minCoeff(), 0) << place;
      EXPECT_GE(gaps.minCoeff(), -1e-8) << place;
      EXPECT_LT(gaps.cwiseProduct(forces).cwiseAbs().maxCoeff(), 1e-8 * forces.sum()) << place;
      EXPECT_EQ((forces.array() > 0).all(), place <= 0.2);
    }
  }
}

// Law: the load of a depth presses the face to this depth, with the same places in contact and the
// same stiffness.
TEST(PressedPlaces, ALoadIsTheInverseOfADepth) {
  for (const double place : {0.0, 0.3, 0.6}) {
    OnPlate on({{place, 0}, 0.1});
    const double depth = 0.01;
    ASSERT_TRUE(on.pressed.Solve(on.compliance, on.free, {&depth, 1}, &on.forces));
    const double load = on.forces.sum();
    Eigen::VectorXd forces = Eigen::VectorXd::Zero(on.forces.size());
    ASSERT_TRUE(on.loaded.Solve(on.compliance, on.free, {&load, 1}, &forces));
    EXPECT_NEAR(on.loaded.deflection(0) / depth, 1, 1e-9);
    EXPECT_LT((forces - on.forces).cwiseAbs().maxCoeff(), 1e-7 * load);
    EXPECT_NEAR(on.loaded.Stiffness(0) / on.pressed.Stiffness(0), 1, 1e-9);
    EXPECT_NEAR(on.pressed.Stiffness(0) * depth / load, 1, 1e-9);
  }
}

// Reference: a clamped plate under a ring of radius b about its centre, on the ring (Timoshenko and
// Woinowsky-Krieger, art. 17): w = F a^2 / (8 pi D) (2 b^2 ln b + (1 - b^4) / 2).
TEST(PressedPlaces, AtTheCentreARigidFacePressesWithARing) {
  PlateModel small({kPlateRadius, kPlateThickness, kYoung, kPoisson});
  PlateLargeModel large({.radius = kPlateRadius,
                         .thickness = kPlateThickness,
                         .young_modulus = kYoung,
                         .poisson_ratio = kPoisson});
  for (const double b : {0.02, 0.1, 0.3, 0.6}) {
    const double depth = 1e-4 * kPlateThickness;
    const double ring = 8 * std::numbers::pi * Rigidity() / (kPlateRadius * kPlateRadius) /
                        (2 * b * b * std::log(b) + (1 - std::pow(b, 4)) / 2);
    for (DeformationModel* plate :
         {static_cast<DeformationModel*>(&small), static_cast<DeformationModel*>(&large)}) {
      const Contact press = Rigid(Moved({0, 0}, depth, 2 * b * kPlateRadius));
      const auto response = contacts::Answer(*plate, press);
      EXPECT_NEAR(-response.force_O.z() / depth / ring, 1, 2e-3) << b;
      EXPECT_NEAR(response.stiffness_O(2, 2) / ring, 1, 2e-3) << b;
    }
  }
}

// Laws: the answer does not depend on the direction. If the symmetry of a face is not used (two
// tools that are not in line have no common mirror plane), the answer is the same. A press very
// near the centre gives the answer at the centre.
TEST(PressedPlaces, TheAnswerDoesNotDependOnDirectionOrSymmetry) {
  PlateLargeModel plate({.radius = kPlateRadius,
                         .thickness = kPlateThickness,
                         .young_modulus = kYoung,
                         .poisson_ratio = kPoisson});
  const double depth = 2 * kPlateThickness, width = 0.2 * kPlateRadius;
  const auto force = [&](const std::vector<Contact>& contacts) {
    plate.Reset();
    return contacts::Respond(plate, contacts).front().force_O.z();
  };
  const double along = force({Rigid(Moved({0.02, 0}, depth, width))});
  const double turned = force({Rigid(Moved({0.012, 0.016}, depth, width))});
  EXPECT_NEAR(turned / along, 1, 1e-9);
  const double beside = force({Rigid(Moved({0.02, 0}, depth, width)), Loaded({0, 0.03}, 1e-9)});
  EXPECT_NEAR(beside / along, 1, 1e-4);
  const double centre = force({Rigid(Moved({0, 0}, depth, width))});
  const double near = force({Rigid(Moved({1e-6, 0}, depth, width))});
  EXPECT_NEAR(near / centre, 1, 1e-3);
}

// Law: the stiffness is the derivative of the force, the force under a load the load itself.
TEST(PressedPlaces, StiffnessIsTheDerivativeOnTheStretchedPlate) {
  PlateLargeModel plate({.radius = kPlateRadius,
                         .thickness = kPlateThickness,
                         .young_modulus = kYoung,
                         .poisson_ratio = kPoisson});
  for (const double place : {0.0, 0.3, 0.6}) {
    for (const double depth : {0.3, 2.0, 4.0}) {
      const auto at = [&](double w) {
        return contacts::Answer(plate, Rigid(Moved({place * kPlateRadius, 0}, w * kPlateThickness,
                                                   0.3 * kPlateRadius)));
      };
      const double step = 1e-4;
      const double slope = (at(depth - step).force_O.z() - at(depth + step).force_O.z()) /
                           (2 * step * kPlateThickness);
      const auto response = at(depth);
      EXPECT_NEAR(response.stiffness_O(2, 2) / slope, 1, 1e-3) << place << ' ' << depth;
      const auto back = contacts::Answer(
          plate,
          Rigid(Loaded({place * kPlateRadius, 0}, -response.force_O.z(), 0.3 * kPlateRadius)));
      EXPECT_NEAR(back.displacement_O.z() / (-depth * kPlateThickness), 1, 1e-6);
    }
  }
}

// A face without a load has no forces and moves with the plate.
TEST(PressedPlaces, AFaceWithoutALoadDoesNothing) {
  PlateLargeModel plate({.radius = kPlateRadius,
                         .thickness = kPlateThickness,
                         .young_modulus = kYoung,
                         .poisson_ratio = kPoisson});
  const auto response = contacts::Answer(plate, Rigid(Loaded({0.01, 0}, 0, 0.004)));
  EXPECT_EQ(response.validity, Validity::kValid);
  EXPECT_EQ(response.force_O.z(), 0);
  EXPECT_EQ(response.displacement_O.z(), 0);
}

}  // namespace
}  // namespace palpate::plate
