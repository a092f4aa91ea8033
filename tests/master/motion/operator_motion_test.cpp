#include "master/motion/operator_motion.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kStiffest = 2000;     // [N/m]
constexpr double kMotionTick = 0.001;  // [s]

Vector3d Somewhere(std::mt19937_64* random, double size = 1) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return {uniform(*random), uniform(*random), uniform(*random)};
}

TeleopTransform AnyTransform(std::mt19937_64* random) {
  std::uniform_real_distribution<double> scale(0.1, 3);
  TeleopTransform transform;
  transform.position_scale = scale(*random);
  transform.force_scale = scale(*random);
  const Vector3d turn = Somewhere(random, 3);
  transform.R_SM = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  transform.offset = Somewhere(random);
  return transform;
}

MotionOptions AnyOptions(std::mt19937_64* random) {
  MotionOptions options;
  const auto coin = [random] { return ((*random)() & 1U) != 0; };
  for (int i = 0; i < 3; ++i) options.locked[i] = coin();
  if (coin()) {
    const Vector3d a = Somewhere(random), b = Somewhere(random);
    options.box = Fixture{Fixture::Kind::kBox, a.cwiseMin(b), a.cwiseMax(b), 0};
  }
  if (coin()) {
    options.fixtures.push_back({Fixture::Kind::kSphere, Somewhere(random), {0, 0, 1}, 0.3});
    options.fixtures.push_back({Fixture::Kind::kLine, Somewhere(random), {0, 0, 1}, 0});
  }
  if (coin()) options.contact_speed = 0.02;
  return options;
}

// A device in M at `p_M`.
DeviceReading ReadingAt(const Vector3d& p_M) {
  DeviceReading reading;
  reading.p_M = p_M;
  return reading;
}

// Reference: T^p with the offset that the slave sets at the first command of an epoch maps that
// command to the present tip. So the next target must be the tip, too, for a device at rest: with
// any settings, wherever tool and device are.
TEST(OperatorMotionPropertyTest, EngagingNeverMovesTheTool) {
  std::mt19937_64 random(5);
  for (int round = 0; round < 2000; ++round) {
    OperatorMotion motion(AnyOptions(&random), kStiffest);
    TeleopTransform transform = AnyTransform(&random);
    OperatorMotion::Situation now;
    now.dt = kMotionTick;
    motion.SetSurface({true, Somewhere(&random).normalized(), 0.001, 0});
    Vector3d tip = Somewhere(&random);  // S
    for (std::uint32_t epoch = 1; epoch <= 4; ++epoch) {
      // Clutched: the device moves without commanding the tool.
      now.engaged = now.follows = false;
      const DeviceReading reading = ReadingAt(Somewhere(&random));
      motion.Command(reading, transform, now);
      now.epoch = epoch;
      now.engaged = true;
      const Vector3d first = motion.Command(reading, transform, now).p_M;
      EXPECT_EQ(first, reading.p_M);
      transform.ZeroOffset(first, tip);
      now.follows = true;
      for (int i = 0; i < 3; ++i) {
        const DeviceReading command = motion.Command(reading, transform, now);
        ASSERT_LT((transform.ToSlave(command.p_M) - tip).norm(), 1e-12) << round;
        ASSERT_LT(motion.ForceAtDevice({0, 0, 0}).norm(), 1e-9) << "and no spring pulls";
      }
      // Then the tool follows random device positions.
      for (int i = 0; i < 20; ++i) {
        tip = transform.ToSlave(motion.Command(ReadingAt(Somewhere(&random)), transform, now).p_M);
      }
    }
  }
}

// Reference: virtual work. The command's motion for a small motion of the device, with the force at
// the command, against the same motion of the device with the force at the device. Springs are
// excluded: they are the force without a contact. Linear within the step, so the tolerance is
// rounding.
TEST(OperatorMotionPropertyTest, DeviceAndCommandExchangeTheSamePower) {
  std::mt19937_64 random(6);
  int limited = 0;
  for (int round = 0; round < 2000; ++round) {
    MotionOptions options = AnyOptions(&random);
    options.contact_speed = 0;
    OperatorMotion motion(options, kStiffest);
    const TeleopTransform transform = AnyTransform(&random);
    OperatorMotion::Situation now{1, true, true, kMotionTick};
    motion.Command(ReadingAt(Somewhere(&random)), transform, now);
    Vector3d p = Somewhere(&random, 2);
    motion.Command(ReadingAt(p), transform, now);
    const Vector3d from = motion.Command(ReadingAt(p), transform, now).p_M;
    const Vector3d step = Somewhere(&random, 1e-6), f_M = Somewhere(&random);
    const Vector3d at_device = motion.ForceAtDevice(f_M) - motion.ForceAtDevice({0, 0, 0});
    const Vector3d to = motion.Command(ReadingAt(p + step), transform, now).p_M;
    // A step that reaches the box's wall is not linear.
    const Vector3d after = motion.ForceAtDevice(f_M) - motion.ForceAtDevice({0, 0, 0});
    if ((after - at_device).norm() > 1e-9) continue;
    ASSERT_NEAR(at_device.dot(step), f_M.dot(to - from), 1e-14) << round;
    limited += (to - from - step).norm() > 1e-9 ? 1 : 0;
  }
  EXPECT_GT(limited, 1000) << "the test did not exercise locks and box";
}

// All springs together, with locks and rotated, scaled frames. Reference as in fixture_test: the
// damping b = K T / 2 of the device covers every closed path, with K = 2000 N/m in sum.
TEST(OperatorMotionPropertyTest, LocksBoxAndFixturesCreateNoEnergy) {
  std::mt19937_64 random(7);
  int pulled = 0;
  for (int round = 0; round < 1000; ++round) {
    MotionOptions options = AnyOptions(&random);
    options.contact_speed = 0;
    OperatorMotion motion(options, kStiffest);
    const TeleopTransform transform = AnyTransform(&random);
    const OperatorMotion::Situation now{1, true, true, kMotionTick};
    const Vector3d begin = Somewhere(&random);
    Vector3d p = begin;
    double gained = 0, size = 0;
    for (int i = 0; i <= 100; ++i) {
      motion.Command(ReadingAt(p), transform, now);
      const Vector3d next = i == 100 ? begin : Vector3d(p + Somewhere(&random, 0.1));
      const Vector3d f = motion.ForceAtDevice({0, 0, 0}), dp = next - p;
      const double damped = kStiffest / 2 * dp.squaredNorm();
      gained += f.dot(dp) - damped;
      size += std::abs(f.dot(dp)) + damped;
      pulled += f.norm() > 0 ? 1 : 0;
      p = next;
    }
    ASSERT_LE(gained, 1e-13 * size) << round;
  }
  EXPECT_GT(pulled, 50000);
}

// Tests the lag of the speed limit with the stiffest contact that may be rendered. Reference:
// energy. The operator's work on random presses and retreats with a closed path is at least the
// work at the commanded position, less the energy created by held forces, which b = K T / 2
// dissipates.
TEST(OperatorMotionPropertyTest, TheSpeedLimitCreatesNoEnergy) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> speed(-0.3, 0.3);  // [m/s]
  int lagged = 0;
  for (int round = 0; round < 500; ++round) {
    MotionOptions options;
    options.contact_speed = 0.01;
    OperatorMotion motion(options, kStiffest);
    const double K = motion.contact_stiffness();
    const TeleopTransform transform;
    const OperatorMotion::Situation now{1, true, true, kMotionTick};
    DeviceGuide surface{true, {0, -1, 0}, 0, 0};
    motion.SetSurface(surface);
    const Vector3d begin(0, 0.001, 0);  // the surface is y = 0
    Vector3d p = begin;
    double gained = 0;
    const auto step_to = [&](const Vector3d& next) {
      const Vector3d c = motion.Command(ReadingAt(p), transform, now).p_M;
      surface.gap_M = c.y();
      motion.SetSurface(surface);
      const Vector3d f = motion.ForceAtDevice({0, K * std::max(0.0, -c.y()), 0});
      const Vector3d dp = next - p;
      gained += f.dot(dp) - kStiffest / 2 * dp.squaredNorm();
      lagged += (c - p).norm() > 0 ? 1 : 0;
      p = next;
    };
    double v = 0;
    for (int i = 0; i < 300; ++i) {
      if (i % 20 == 0) v = speed(random);
      step_to(p + Vector3d(0, std::clamp(p.y() + v * kMotionTick, -0.02, 0.02) - p.y(), 0));
    }
    while (p.y() < begin.y() - 1e-6) step_to(p + Vector3d(0, 1e-4, 0));
    step_to(begin);
    ASSERT_LE(gained, 1e-15) << round;
  }
  EXPECT_GT(lagged, 10000);
}

TEST(OperatorMotionTest, LimitsTheApproachOnly) {
  MotionOptions options;
  options.contact_speed = 0.010;
  OperatorMotion motion(options, kStiffest);
  TeleopTransform transform;
  transform.position_scale = 0.5;
  const OperatorMotion::Situation now{1, true, true, kMotionTick};
  DeviceGuide surface{true, {0, -1, 0}, 0, 0};
  motion.SetSurface(surface);
  motion.Command(ReadingAt({0, 0, 0}), transform, now);
  DeviceReading fast = ReadingAt({0.005, -0.003, 0});
  fast.v_M = {5, -3, 0};
  const DeviceReading command = motion.Command(fast, transform, now);
  EXPECT_NEAR(command.p_M.x(), 0.005, 1e-15) << "along the surface it follows";
  EXPECT_NEAR(command.p_M.y(), -0.010 / 0.5 * kMotionTick, 1e-15) << "10 mm/s of the tool";
  EXPECT_NEAR(command.v_M.y(), -0.010 / 0.5, 1e-15);
  EXPECT_NEAR(motion.ForceAtDevice({0, 0, 0}).y(), 1000 * (0.003 - 20e-6), 1e-9) << "and resists";
  EXPECT_NEAR(motion.Command(ReadingAt({0, 0.001, 0}), transform, now).p_M.y(), 0.001, 1e-15);
  surface.gap_M = 0.025;
  motion.SetSurface(surface);  // 25 mm away at most 0.1 m/s of the device
  EXPECT_NEAR(motion.Command(ReadingAt({0, -0.5, 0}), transform, now).p_M.y(),
              0.001 - 0.1 * kMotionTick, 1e-15);
}

// If the surface is lost during the lag, the command must not jump.
TEST(OperatorMotionTest, ALostSurfaceReleasesNoJump) {
  MotionOptions options;
  options.contact_speed = 0.010;
  OperatorMotion motion(options, kStiffest);
  const TeleopTransform transform;
  const OperatorMotion::Situation now{1, true, true, kMotionTick};
  DeviceGuide surface{true, {0, -1, 0}, 0, 0};
  motion.SetSurface(surface);
  motion.Command(ReadingAt({0, 0, 0}), transform, now);
  double last = motion.Command(ReadingAt({0, -0.001, 0}), transform, now).p_M.y();
  surface.known = false;
  motion.SetSurface(surface);
  for (int i = 0; i < 200; ++i) {
    const double y = motion.Command(ReadingAt({0, -0.001, 0}), transform, now).p_M.y();
    ASSERT_GE(y, last - 0.010 * kMotionTick - 1e-15);
    last = y;
  }
  EXPECT_NEAR(last, -0.001, 1e-15) << "it catches up";
}

TEST(OperatorMotionAllocationTest, ATickDoesNotAllocate) {
  std::mt19937_64 random(10);
  MotionOptions options;
  options.ParseLocks("z");
  options.box = Fixture::ParseBox("0,0,0:10,10,10");
  options.fixtures.push_back(Fixture::Parse("cone:0,0,0:0,1,0:30"));
  options.contact_speed = 0.01;
  OperatorMotion motion(options, kStiffest);
  const TeleopTransform transform = AnyTransform(&random);
  const long before = AllocationCount();
  for (int i = 0; i < 1000; ++i) {
    const OperatorMotion::Situation now{static_cast<std::uint32_t>(i / 100), true, i % 100 > 5,
                                        kMotionTick};
    motion.SetSurface({true, {0, -1, 0}, 0, 0});
    motion.Command(motion.ToMaster(ReadingAt(Somewhere(&random))), transform, now);
    (void)motion.ForceAtDevice({1, 2, 3});
  }
  EXPECT_EQ(AllocationCount(), before);
}

}  // namespace
}  // namespace palpate
