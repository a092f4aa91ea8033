// Tests the patch (the contact model that the slave sends) in the haptic loop: with any delay, with
// late updates, from a malicious slave, and where the patch is wrong.
#include <cmath>
#include <functional>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "master/device/sim_hand.h"
#include "tests/master/haptics/port_energy.h"
#include "tests/master/haptics/rig.h"
#include "tests/master/haptics/wall_patch.h"

namespace palpate {
namespace {

constexpr double kK = 500;           // of the wall [N/m]
constexpr double kSurface = -0.004;  // [m]

class DelayTest : public testing::TestWithParam<double> {};

// Reference: the wall's law at the commanded position. Tolerance: single precision of vertices and
// compliance, 1e-7 of 4 mm under 500 N/m.
TEST_P(DelayTest, TheForceIsThatOfTheCommandedPlaceAtAnyRoundTrip) {
  const double trip = GetParam();
  Rig rig({.K = kK, .delay = trip / 2}, RenderMode::kLocal, 100);
  rig.patches.Put(WallPatch(kK, 1));
  Puppet puppet;
  rig.Run(puppet, 0.1 + 2 * trip);
  rig.Engage(puppet, 0.2 + 2 * trip);
  ASSERT_EQ(rig.state(), OperatorState::kFollowing);
  double worst = 0, deepest = 0;
  const auto look = [&](const TickRecord& record) {
    const double depth = std::max(0.0, kSurface - record.p_S.y());
    deepest = std::max(deepest, depth);
    worst = std::max(worst, (record.chain.local - Eigen::Vector3d(0, kK * depth, 0)).norm());
  };
  for (int press = 0; press < 2; ++press) {
    for (const double y : {-0.008, 0.0}) {
      rig.Glide(puppet, {0.003 * press, y, 0});
      look(rig.loop.record());
      rig.Run(puppet, 0.1, look);
    }
  }
  ASSERT_EQ(rig.state(), OperatorState::kFollowing);
  EXPECT_NEAR(deepest, 0.004, 1e-9);
  EXPECT_LT(worst, 1e-5) << "N, at a round trip of " << trip << " s";
  rig.Run(puppet, 0.1 + trip);
  EXPECT_LT((rig.slave.tip() - rig.loop.record().p_S).norm(), 1e-6) << "drift";
}

INSTANTIATE_TEST_SUITE_P(RoundTrips, DelayTest, testing::Values(0.0, 0.05, 0.1, 0.5, 1.0, 5.0));

// Outside the patch the plane of the states is used, without a step of the force, and this is
// reported.
TEST(PatchTest, OutsideThePatchThePlaneIsUsed) {
  Rig rig({.K = kK}, RenderMode::kLocal, 100);
  rig.patches.Put(WallPatch(kK, 1));
  Puppet puppet;
  rig.Run(puppet, 0.1);
  rig.Engage(puppet, 0.2);
  rig.Glide(puppet, {0.03, 0, 0});
  rig.Glide(puppet, {0.03, -0.006, 0});
  rig.Run(puppet, 0.1);
  EXPECT_TRUE(rig.loop.record().chain.reasons.Has(Reason::kPlane));
  EXPECT_NEAR(rig.loop.record().chain.local.y(), kK * 0.002, 1e-3);
}

// A patch for another settings revision than the master's is not rendered.
TEST(PatchTest, APatchOfOtherSettingsWaits) {
  Rig rig({.K = kK}, RenderMode::kLocal, 100);
  ReceivedPatch other = WallPatch(4 * kK, 1);
  other.patch.settings_revision = 7;
  rig.patches.Put(other);
  Puppet puppet;
  rig.Run(puppet, 0.1);
  rig.Engage(puppet, 0.2);
  rig.Glide(puppet, {0, -0.006, 0});
  rig.Run(puppet, 0.1);
  EXPECT_NEAR(rig.loop.record().chain.local.y(), kK * 0.002, 1e-3);
}

// Reference: the wall. A model that is eight times too stiff is worse than holding the last force,
// so the held force is rendered instead and this is reported. This does not happen with a correct
// model.
TEST(PatchTest, AModelWorseThanTheHoldIsNotShown) {
  for (const double times : {1.0, 8.0}) {
    Rig rig({.K = 200, .delay = 0.01}, RenderMode::kLocal, 100);
    rig.patches.Put(WallPatch(200 * times, 1));
    Puppet puppet;
    rig.Run(puppet, 0.1);
    rig.Engage(puppet, 0.2);
    int held = 0;
    const auto look = [&](const TickRecord& record) {
      held += record.chain.reasons.Has(Reason::kHeld) ? 1 : 0;
    };
    for (int press = 0; press < 3; ++press) {
      for (const double y : {-0.008, -0.005}) {
        rig.Glide(puppet, {0, y, 0});
        rig.Run(puppet, 0.2, look);
      }
    }
    EXPECT_EQ(held > 0, times > 1) << times;
    const double truth = 200 * (kSurface - rig.loop.record().p_S.y());
    EXPECT_NEAR(rig.loop.record().chain.local.y(), truth, 1e-2) << times;
  }
}

struct FalsePatches {
  std::string name;
  std::function<void(ReceivedPatch*, int n)> falsify;  // n: patches since the beginning
};
void PrintTo(const FalsePatches& row, std::ostream* out) {
  *out << row.name;
}
void TurnTo(SurfacePatch* patch, double angle) {
  const double reach = 0.02;
  for (const int end : {0, 1}) {
    const double along = end == 0 ? reach : -reach;
    patch->vertices[static_cast<std::size_t>(end)] =
        Eigen::Vector3d(along * std::cos(angle), kSurface + along * std::sin(angle), 0)
            .cast<float>();
  }
}

// A learnt law comes with estimates; this sets false values of both.
void SetLearnt(ReceivedPatch* received, double ratio) {
  SurfacePatch& patch = received->patch;
  patch.vertices_per_cell = 1;
  patch.vertex_count = 1;
  patch.cell_count = 0;
  patch.vertices[0] = Eigen::Vector3f(0, static_cast<float>(kSurface), 0);
  patch.normal = Eigen::Vector3d::UnitY();
  received->law.ratios.fill(ratio);
}

class MaliciousPatchTest : public testing::TestWithParam<FalsePatches> {};

// Reference: the master's own limits, with any patch fifty times per second.
TEST_P(MaliciousPatchTest, TheHandKeepsItsLimits) {
  Rig rig({.K = 600, .sensor_rate = 500}, RenderMode::kLocal, 3.3, 0.2);
  SimHand hand(0.004, 0.020);
  PortEnergy energy;
  int tick = 0, n = 0;
  std::uint32_t epoch = 0;
  rig.Run(hand, 12, [&](const TickRecord& record) {
    energy.Add(record);
    ASSERT_TRUE(record.chain.local.allFinite());
    if (tick++ % 20 != 0) return;
    ReceivedPatch patch = WallPatch(600, ++epoch);
    GetParam().falsify(&patch, n++);
    rig.patches.Put(patch);
  });
  EXPECT_LE(energy.peak(), 3.3 + 1e-9);
  EXPECT_LE(energy.step(), 0.2 + 1e-9);
  EXPECT_GE(energy.min(), -1e-3);
}

INSTANTIATE_TEST_SUITE_P(
    Rows, MaliciousPatchTest,
    testing::Values(
        FalsePatches{"honest", [](ReceivedPatch*, int) {}},
        FalsePatches{"K_1e9", [](ReceivedPatch* p, int) { p->patch.compliance *= 0; }},
        FalsePatches{
            "K_alternates",
            [](ReceivedPatch* p, int n) { p->patch.compliance *= n % 2 == 0 ? 1e-3F : 100.F; }},
        FalsePatches{"compliance_is_negative",
                     [](ReceivedPatch* p, int) { p->patch.compliance *= -1; }},
        FalsePatches{"ratios_1e6", [](ReceivedPatch* p, int) { p->law.ratios.fill(1e6); }},
        FalsePatches{"ratios_stand_on_edge",
                     [](ReceivedPatch* p, int n) {
                       p->law.ratios.fill(0);
                       p->law.ratios[static_cast<std::size_t>(n % kLawPoints)] = 50;
                     }},
        FalsePatches{"surface_beats", [](ReceivedPatch* p,
                                         int n) { p->law.offset.y() = 0.005 * std::sin(0.6 * n); }},
        FalsePatches{"surface_flees", [](ReceivedPatch* p, int) { p->law.velocity.y() = 1e3; }},
        FalsePatches{
            "surface_flickers",
            [](ReceivedPatch* p, int n) { p->law.offset.y() = n % 2 == 0 ? 0.01 : -0.01; }},
        FalsePatches{"normal_spins", [](ReceivedPatch* p, int n) { TurnTo(&p->patch, 0.3 * n); }},
        FalsePatches{"normal_flips",
                     [](ReceivedPatch* p, int n) { TurnTo(&p->patch, n % 2 == 0 ? 0 : M_PI); }},
        FalsePatches{"sphere_of_a_kilometre",
                     [](ReceivedPatch* p, int) { p->patch.tools[0].radius = 1e3; }},
        FalsePatches{"learnt", [](ReceivedPatch* p, int) { SetLearnt(p, 1); }},
        FalsePatches{"learnt_says_nothing", [](ReceivedPatch* p, int) { SetLearnt(p, 1e-3); }},
        FalsePatches{"learnt_says_1e6", [](ReceivedPatch* p, int) { SetLearnt(p, 1e6); }},
        FalsePatches{"learnt_alternates",
                     [](ReceivedPatch* p, int n) { SetLearnt(p, n % 2 == 0 ? 0.01 : 100); }},
        FalsePatches{"learnt_and_pulls", [](ReceivedPatch* p, int) { SetLearnt(p, -5); }},
        FalsePatches{"one_epoch_for_ever",
                     [](ReceivedPatch* p, int n) {
                       p->patch.epoch = p->law.epoch = 1;
                       p->law.revision = static_cast<std::uint32_t>(n);
                       p->law.ratios.fill(n % 2 == 0 ? 100 : 0.01);
                     }}),
    [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace palpate
