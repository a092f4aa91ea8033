// Tools that slide: a block by Coulomb's law in every direction, closed paths in and out of
// contact, and a sphere that rubs over a slab at 100 mm/s.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/zone/fem_zone_model.h"
#include "tests/slave/mechanics/zone/pressed_slab.h"

namespace palpate {
namespace {

using namespace zone_tests;  // NOLINT(google-build-using-namespace): its helpers are for here

constexpr double kNu = 0.4;
constexpr double kEndless = std::numeric_limits<double>::infinity();

FemZoneModel::Options Rough(double friction, const Tool& tool) {
  FemZoneModel::Options options;
  options.contact = std::isinf(friction) ? ContactLaw::kBonded : ContactLaw::kFriction;
  options.friction = std::isinf(friction) ? 0 : friction;
  options.tool = tool;
  return options;
}

ContactResponse Move(FemZoneModel* model, Contact* contact, const Vector3d& displacement) {
  contact->prescribed_O = displacement;
  std::vector<ContactResponse> response(1);
  model->Respond({contact, 1}, response);
  EXPECT_NE(response[0].validity, Validity::kFailed)
      << model->failure() << " at " << displacement.transpose();
  return response[0];
}

// A flat block under a normal force N sticks, as a bonded one does, and slides at mu N against its
// way, whichever this is. Its five points let go one after the other from 0.7 mu N on. Where it
// slid no farther than the body gave way, the points still move towards each other: up to 4 degrees
// off the way. Tolerance otherwise: twice the steps' convergence of 5e-4.
TEST(Block, SticksBelowCoulombsForceAndSlidesAtItInEveryDirection) {
  constexpr double kFriction = 0.4, kStep = 1e-4, kDepth = 1e-3;  // [-], [m]
  const Slab slab(12, kNu);
  FemZoneModel model(slab.mesh, slab.held, kModulus, kNu, Rough(kFriction, {}));
  FemZoneModel bonded(slab.mesh, slab.held, kModulus, kNu, Rough(kEndless, {}));
  Contact contact{.p_O = {0.04, 0.04, 0.04}, .width = 0.016};  // no point enters or leaves
  for (int turn = 0; turn < 7; ++turn) {
    const double angle = 2 * std::numbers::pi * turn / 7;
    const Vector3d along(std::cos(angle), std::sin(angle), 0);
    model.Reset();
    Move(&model, &contact, {0, 0, -kDepth});
    int stuck = 0, slid = 0;
    for (int k = 1; k <= 16; ++k) {
      const Vector3d way = k * kStep * along - Vector3d(0, 0, kDepth);
      const Vector3d force = Move(&model, &contact, way).force_O,
                     held = Move(&bonded, &contact, way).force_O;
      const double most = -kFriction * force.z(), T = force.head<2>().norm();
      EXPECT_LE(T, (1 + 1e-3) * most);
      if (held.head<2>().norm() < 0.6 * most) {
        EXPECT_LT((force - held).norm(), 1e-3 * held.norm()) << turn << " " << k;
        ++stuck;
      } else if (k > 12) {
        EXPECT_GE(T, (1 - 1e-3) * most) << turn << " " << k;
        EXPECT_GT(force.dot(along), std::cos(4 * std::numbers::pi / 180) * T);
        ++slid;
      }
    }
    EXPECT_GE(stuck, 2);
    EXPECT_EQ(slid, 4);
  }
}

// Smooth paths of random waves that begin and end above the body, touch it and leave it in between:
// whatever the friction, the tool never gets work from them; without friction it gets back what it
// gave. Tolerance: the trapezoidal rule over 150 steps, 1e-3 of what goes to and fro.
TEST(ClosedPath, GivesNoEnergyWhateverTheFriction) {
  constexpr int kSteps = 150;
  const Slab slab(12, kNu);
  const Tool sphere{.shape = Tool::Shape::kRound, .radius = 0.02};
  Contact contact{.p_O = {0.04, 0.04, 0.04}};
  for (const double friction : {0.0, 0.3, 1.0, kEndless}) {
    FemZoneModel model(slab.mesh, slab.held, kModulus, kNu, Rough(friction, sphere));
    std::mt19937 random(7);
    std::uniform_real_distribution<double> wave(-1, 1);
    for (int path = 0; path < 4; ++path) {
      std::vector<Vector3d> way(kSteps + 1, Vector3d::Zero());
      for (int j = 1; j <= 3; ++j) {
        Vector3d a, b;
        for (int c = 0; c < 3; ++c) a[c] = wave(random) / j, b[c] = wave(random) / j;
        for (int k = 0; k <= kSteps; ++k) {
          const double angle = 2 * std::numbers::pi * j * k / kSteps;
          way[Index(k)] += 0.0015 * (std::sin(angle) * a + std::cos(angle) * b);
        }
      }
      const auto top = std::ranges::max_element(way.begin(), way.end() - 1, {},
                                                [](const Vector3d& p) { return p.z(); });
      std::rotate(way.begin(), top, way.end() - 1);  // the last one is the first
      way.back() = way.front();
      const double lift = 0.001 - way.front().z();
      double work = 0, size = 0;
      int apart = 0;
      Vector3d force = Vector3d::Zero();
      model.Reset();
      for (int k = 0; k <= kSteps; ++k) {
        way[Index(k)].z() += lift;
        const Vector3d next = Move(&model, &contact, way[Index(k)]).force_O;
        if (k > 0) {
          const double step = 0.5 * (force + next).dot(way[Index(k)] - way[Index(k - 1)]);
          work += step;
          size += std::abs(step);
        }
        if (next.isZero(0)) ++apart;
        force = next;
      }
      EXPECT_GT(apart, 10);
      EXPECT_LT(apart, kSteps - 10);
      EXPECT_EQ(force, Vector3d::Zero());
      EXPECT_GE(work, -1e-3 * size) << friction << " " << path;
      if (friction == 0) EXPECT_LE(work, 1e-3 * size) << path;
      if (friction > 0) EXPECT_GE(work, 0.01 * size) << friction << " " << path;
    }
  }
}

// A sphere that rubs over a slab by 0.1 mm per update, as at 100 mm/s and 1 kHz, and its zone that
// follows: against the whole slab as one zone, on whose elements nothing changes. What both have in
// common is the mesh's ripple from node to node.
class Rubbing : public testing::TestWithParam<int> {};

// The zone's force stays within its bound of the other one, and no update changes it by more than
// the bounds and what a tool that sticks would: where a zone is made anew, too. 5e-4 of the force,
// to which steps converge, for what earlier answers lacked: friction keeps it.
TEST_P(Rubbing, HasNoStepBeyondItsBoundWhereZonesChange) {
  constexpr double kStep = 1e-4, kDepth = 2e-3, kHistory = 5e-4;  // [m], [m], [-]
  const SolidMesh mesh = MeshBox({0.12, 0.04, 0.02}, {24, 8, 4});
  const HeldNodes held = FixedWhere(mesh, [](const Vector3d& p) { return p.z() == 0; });
  FemZoneModel::Options options = Rough(0.3, {.shape = Tool::Shape::kRound, .radius = 0.01});
  FemZoneModel zone(mesh, held, kModulus, kNu, options);
  options.least_radius = 1;
  FemZoneModel whole(mesh, held, kModulus, kNu, options);
  Contact contact{.p_O = {0.02, 0.02, 0.02}};
  for (int k = 1; k < 10; ++k) {
    for (FemZoneModel* model : {&zone, &whole}) Move(model, &contact, {0, 0, -0.1 * k * kDepth});
  }
  std::array<ContactResponse, 2> before{};
  double sticks = 0;
  for (int k = 0; k <= GetParam(); ++k) {
    const Vector3d way(k * kStep, 0, -kDepth);
    const std::array<ContactResponse, 2> now{Move(&zone, &contact, way),
                                             Move(&whole, &contact, way)};
    const auto slack = [&](const std::array<ContactResponse, 2>& pair) {
      return pair[0].force_error + pair[1].force_error + kHistory * pair[1].force_O.norm();
    };
    EXPECT_LE((now[0].force_O - now[1].force_O).norm(), slack(now)) << k;
    if (k > 0) {
      const Vector3d step = now[0].force_O - before[0].force_O,
                     expected = now[1].force_O - before[1].force_O;
      if (k == 1) sticks = expected.norm();
      EXPECT_LE((step - expected).norm(), slack(now) + slack(before)) << k;
      EXPECT_LE(step.norm(), sticks + slack(now) + slack(before)) << k;
    }
    before = now;
  }
}
INSTANTIATE_TEST_SUITE_P(TwoZones, Rubbing, testing::Values(100));
INSTANTIATE_TEST_SUITE_P(FineTwelveZones, Rubbing, testing::Values(600));

}  // namespace
}  // namespace palpate
