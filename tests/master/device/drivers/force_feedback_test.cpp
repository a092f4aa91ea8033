// Tests drivers with force feedback whose fake can be frozen and made to fail.
#include <random>

#include <gtest/gtest.h>

#include "tests/master/device/drivers/driver_bench.h"

namespace palpate {
namespace {

class ForceFeedbackTest : public testing::TestWithParam<BenchKind (*)()> {
 protected:
  ForceFeedbackTest() : bench_(GetParam()()) {}
  DriverBench bench_;
};

// A frozen device repeats its last position, or its own thread has stopped.
TEST_P(ForceFeedbackTest, AFrozenDeviceIsDisengagedAfterTwentyMilliseconds) {
  const std::vector<PressTick> press = SimulatedPress();
  bench_.Open();
  bench_.Play(press, 1500);
  ASSERT_EQ(bench_.rig.state(), OperatorState::kFollowing);
  bench_.fake.freeze(2);
  for (int ms = 1; ms <= 60; ++ms) {
    bench_.Step();
    if (ms < 25) continue;
    EXPECT_EQ(bench_.rig.loop.record().device.fault, DeviceFault::kSilent) << ms;
    EXPECT_FALSE(bench_.rig.slave.engaged()) << ms;
  }
}

// Random motion, switches, faults and freezes: from engagement to force, no path skips a limit.
TEST_P(ForceFeedbackTest, NoPathFromEngagementToForceSkipsALimit) {
  std::mt19937_64 random(7);
  const auto below = [&random](int n) {
    return static_cast<int>(random() % static_cast<unsigned>(n));
  };
  constexpr double kSlew = 200;  // [N/s]
  bench_.Open();
  Eigen::Vector3d last(0, 0, 0), p(0, 0, 0);
  double last_t = 0;
  int with_force = 0;
  for (int i = 0; i < 20000; ++i) {
    p.y() = std::clamp(p.y() + 1e-4 * (below(9) - 4), -0.03, 0.01);
    if (below(400) == 0) p.y() = 1e-3 * (below(40) - 30);  // a jump
    bench_.Place(p);
    if (below(100) == 0) bench_.fake.press(0, below(4) > 0 ? 1 : 0, 0);
    if (below(1500) == 0) bench_.fake.freeze(1 + below(2));
    if (below(40) == 0) bench_.fake.freeze(0);
    if (below(700) == 0) bench_.fake.set_error("", -1, 1 + below(4));
    bench_.Step();
    ASSERT_LE(bench_.Made().norm(), kForceLimit * (1 + 1e-9)) << i;
    const auto [t, asked] = bench_.Asked();  // a frozen device accepts no commands
    ASSERT_LE(asked.norm(), kForceLimit * (1 + 1e-9)) << i;
    if (!asked.isZero(0)) {
      ASSERT_LE((asked - last).norm(), kSlew * (t - last_t) * (1 + 1e-6)) << i;
      if (t > last_t) ++with_force;
    }
    last = asked;
    last_t = t;
  }
  EXPECT_GT(with_force, 1000) << "the test did not exercise forces";
}

// Counts allocations over twelve thousand ticks with presses, releases, faults, a frozen and an
// unplugged device. The first press is not counted, since the fake allocates memory at the first
// call of a function.
TEST_P(ForceFeedbackTest, TicksAllocateNothing) {
  const std::vector<PressTick> press = SimulatedPress();
  bench_.Open();
  long before = 0;
  int followed = 0;
  for (int round = 0; round < 4; ++round) {
    if (round == 1) before = bench_.allocations();
    bench_.Play(press, press.size(), [&](std::size_t i) {
      if (bench_.rig.state() == OperatorState::kFollowing) ++followed;
      if (i == 1500 && round % 2 == 0) bench_.fake.freeze(2);
      if (i == 1600) bench_.fake.freeze(0);
      if (i == 1700) bench_.fake.set_error("", -1, 1);
      if (i == 1800 && (round == 0 || round == 3)) bench_.fake.unplug();
      if (i == 1900) bench_.fake.replug();
    });
  }
  EXPECT_GT(followed, 1000) << "the test did not exercise the loop";
  EXPECT_EQ(bench_.allocations(), before);
}

INSTANTIATE_TEST_SUITE_P(Drivers, ForceFeedbackTest, testing::Values(&TouchBench, &DhdBench),
                         [](const auto& info) { return info.param().name; });

}  // namespace
}  // namespace palpate
