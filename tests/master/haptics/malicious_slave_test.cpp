// A malicious slave, one case per row: the operator gets no more force, no faster change and no
// more energy than the master's own limits allow.
#include <cmath>
#include <functional>
#include <ostream>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "master/device/sim_hand.h"
#include "tests/master/haptics/hand_sequence.h"
#include "tests/master/haptics/port_energy.h"
#include "tests/master/haptics/rig.h"

namespace palpate {
namespace {

using Falsification = std::function<void(SlaveState*, int n)>;  // n: states since the beginning

struct FalseStates {
  std::string name;
  Falsification falsify;
  RenderMode render = RenderMode::kLocal;
  RemoteSettings settings = {0, {}, 1e9};
};
void PrintTo(const FalseStates& row, std::ostream* out) {
  *out << row.name;
}

Falsification Stiffness(double K) {
  return [K](SlaveState* s, int) { s->local_model.stiffness(1, 1) = K; };
}
Falsification Alternating(double K) {
  return [K](SlaveState* s, int n) {
    s->local_model.stiffness(1, 1) = n % 2 == 0 ? K : -K;
    s->local_model.revision = static_cast<std::uint32_t>(n + 2);
  };
}
// Sends a new local model with each state, changed by `change`.
Falsification Restless(std::function<void(LocalModel*, int n)> change) {
  return [change = std::move(change)](SlaveState* s, int n) {
    s->local_model.stiffness = 600 * Eigen::Matrix3d::Identity();
    s->local_model.in_contact = true;
    s->local_model.revision = static_cast<std::uint32_t>(n + 2);
    change(&s->local_model, n);
  };
}
Falsification Force(double first, double second) {
  return
      [=](SlaveState* s, int n) { s->force = Eigen::Vector3d(0, n % 8 < 4 ? first : second, 0); };
}
int Sign(int n) {
  return n % 2 == 0 ? 1 : -1;
}
RemoteSettings ForceScale(double force_scale) {
  RemoteSettings settings{0, {}, 1e9};
  settings.transform.force_scale = force_scale;
  return settings;
}
Eigen::Vector3d Turned(int n) {
  return {std::sin(0.3 * n), std::cos(0.3 * n), 0};
}

const std::vector<FalseStates> kRows{
    {"honest", [](SlaveState*, int) {}},
    {"force_limit_1e9_and_K_1e6", Stiffness(1e6)},
    {"K_1e12", Stiffness(1e12)},
    {"K_2000", Stiffness(2000)},
    {"K_alternates", Alternating(1e5)},
    {"K_alternates_softly", Alternating(1500)},
    {"K_minus_5e4", Stiffness(-5e4)},
    {"K_minus_2e3", Stiffness(-2e3)},
    {"skew_K",
     [](SlaveState* s, int) {
       s->local_model.stiffness(0, 1) = 3e3;
       s->local_model.stiffness(1, 0) = -3e3;
     }},
    {"force_scale_1e9", Stiffness(1e6), RenderMode::kLocal, ForceScale(1e9)},
    {"reference_jumps_along",
     Restless([](LocalModel* m, int n) { m->reference.x() += 0.5 * Sign(n); })},
    {"reference_jumps_across",
     Restless([](LocalModel* m, int n) { m->reference.y() += 0.01 * Sign(n / 16); })},
    {"surface_beats",
     Restless([](LocalModel* m, int n) { m->reference.y() += 0.005 * std::sin(0.12 * n); })},
    {"surface_flees",
     Restless([](LocalModel* m, int n) { m->reference.y() += n % 100 < 50 ? 0.02 : -0.02; })},
    {"preload", [](SlaveState* s, int) { s->local_model.force.y() = 3; }},
    {"preload_comes_and_goes",
     Restless([](LocalModel* m, int n) { m->force.y() = n % 50 < 25 ? 3 : 0; })},
    {"preload_pulls", Restless([](LocalModel* m, int n) { m->force.x() = 3.0 * Sign(n / 20); })},
    {"normal_flips", Restless([](LocalModel* m, int n) { m->normal.y() = Sign(n); })},
    {"normal_spins", Restless([](LocalModel* m, int n) { m->normal = Turned(n); })},
    {"offset_jumps", [](SlaveState* s, int n) { s->offset.y() += 0.05 * Sign(n / 10); }},
    {"offset_far", [](SlaveState* s, int) { s->offset.y() -= 1000; }},
    {"puncture_flickers",
     [](SlaveState* s, int n) {
       if (n / 10 % 2 == 0) s->validity = Validity::kPunctured;
     }},
    {"validity_flickers",
     [](SlaveState* s, int n) {
       if (n / 10 % 2 == 0) s->validity = Validity::kTrackingLost;
     }},
    {"phase_flickers",
     [](SlaveState* s, int n) {
       if (n / 10 % 2 == 0) s->phase = Phase::kHold;
     }},
    {"epoch_flickers", [](SlaveState* s, int n) { s->epoch += n / 10 % 2 == 0 ? 1 : 0; }},
    {"hold_1e9", Force(1e9, -1e9), RenderMode::kHold},
    {"hold_3", Force(3, -3), RenderMode::kHold},
    {"hold_pushes", Force(3, 0), RenderMode::kHold},
    {"hold_tiny_then_3",
     [](SlaveState* s, int n) { s->force = Eigen::Vector3d(0, n < 3000 ? 1e-6 : 3, 0); },
     RenderMode::kHold},
    {"interpolate_1e9", Force(1e9, -1e9), RenderMode::kInterpolate},
    {"interpolate_3", Force(3, -3), RenderMode::kInterpolate},
};

class MaliciousSlaveTest : public testing::TestWithParam<FalseStates> {};

// Reference: the master's own limits, see port_energy.h.
TEST_P(MaliciousSlaveTest, TheHandKeepsItsLimits) {
  Rig rig({.K = 600, .sensor_rate = 500}, GetParam().render, kForceLimit, kSlewLimit);
  rig.settings.Put(GetParam().settings);
  int n = 0;
  rig.slave.falsify = [&](SlaveState* state) { GetParam().falsify(state, n++); };
  SimHand hand(0.004, 0.020);
  PortEnergy energy;
  rig.Run(hand, 12, [&](const TickRecord& record) {
    ASSERT_TRUE(record.chain.sent.allFinite());
    energy.Add(record);
  });
  EXPECT_LE(energy.peak(), kForceLimit * (1 + 1e-12));
  EXPECT_LE(energy.step(), kSlewLimit * (1 + 1e-9));
  EXPECT_GE(energy.min(), -kEnergyLimit);
  EXPECT_GE(rig.loop.passivity().min_balance(), -kEnergyLimit);
}

// The link is cut during a press, and the operator then retreats under the held force. A spring
// would return the energy that it got; a held force returns more.
TEST(GapTest, AForceThatIsHeldIsPaidForToo) {
  Rig rig({.K = 1900}, RenderMode::kLocal, kForceLimit, kSlewLimit);
  Puppet puppet;
  rig.Run(puppet, 0.1);
  rig.Engage(puppet, 0.2);
  rig.Glide(puppet, {0, -0.0055, 0});  // 1.5 mm inside
  EXPECT_GT(rig.loop.record().chain.sent.norm(), 1);
  rig.slave.silent = true;
  while (rig.Tick(puppet).state != OperatorState::kHold) {
  }
  puppet.reading.v_M = {0, 0.060, 0};  // [m/s]
  for (int k = 0; k < 100; ++k) {
    puppet.reading.p_M.y() += 60e-6;
    rig.Tick(puppet);
  }
  EXPECT_GE(rig.loop.passivity().min_balance(), -kEnergyLimit);
}

// Random sequences; `tests/fuzz` searches for further ones.
TEST(HandSequence, NoOrderOfEventsExceedsTheLimits) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const auto bytes = RandomBytes(seed, 300);
    EXPECT_NO_THROW(RunHand(Choices(bytes))) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Rows, MaliciousSlaveTest, testing::ValuesIn(kRows),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace palpate
