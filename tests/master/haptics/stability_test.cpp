// The simulated operator presses remote walls over links of every kind, on a virtual clock.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "master/device/sim_hand.h"
#include "tests/master/haptics/rig.h"

namespace palpate {
namespace {

constexpr double kPressDepth = 0.003;  // [m]

// Results of one press with held forces.
struct PressOutcome {
  double peak_depth = -1;  // [m]
  int followed = 0, damped = 0;
};

PressOutcome RunPress(const VirtualSlave::Options& options) {
  Rig rig(options, RenderMode::kHold, 12);
  SimHand hand(kPressDepth, 0.020);
  PressOutcome press;
  rig.Run(hand, 3.95, [&](const TickRecord& record) {
    press.damped += record.chain.reasons.Has(Reason::kPassivity) ? 1 : 0;
    if (record.state != OperatorState::kFollowing) return;
    ++press.followed;
    press.peak_depth = std::max(press.peak_depth, options.surface - record.p_S.y());
  });
  return press;
}

// Reference: passivity_virtual_wall of reference f. A force held for T = 1/60 s needs
// b > K (T/2 + delay): 1 N s/m, which the control counts on, carries K = 60 N/m with the 5 ms that
// sampling and sending add here; 1000 N/m needs 13 N s/m and must be damped.
TEST(HoldStabilityTest, HeldForcesAreUndampedWithinTheTableAndDampedBeyond) {
  VirtualSlave::Options options;
  options.K = 60;
  const PressOutcome soft = RunPress(options);
  EXPECT_GT(soft.followed, 1800);
  EXPECT_EQ(soft.damped, 0);
  options.K = 1000;
  const PressOutcome stiff = RunPress(options);
  EXPECT_GT(stiff.damped, 0);
  EXPECT_LT(stiff.peak_depth, 1.1 * kPressDepth) << "no growing oscillation";
}

// A light arm with nearly no damping: held forces at 60 Hz make it oscillate, the local model does
// not.
TEST(HoldStabilityTest, ALightArmIsStableWithTheLocalModelButNotWithHeldForces) {
  const auto restlessness = [](RenderMode mode) {
    VirtualSlave::Options options;
    options.K = 1000;
    Rig rig(options, mode, 12);
    SimHand hand(kPressDepth, 0.020, {0.3, 800, 4.0});
    double path = 0, last = 0;
    rig.Run(hand, 2.0, [&](const TickRecord& record) {
      if (rig.t() > 1.2) path += std::abs(record.p_M.y() - last);
      last = record.p_M.y();
    });
    return path;
  };
  EXPECT_LT(restlessness(RenderMode::kLocal), kPressDepth);
  EXPECT_GT(restlessness(RenderMode::kHold), 2 * kPressDepth);
}

}  // namespace
}  // namespace palpate
