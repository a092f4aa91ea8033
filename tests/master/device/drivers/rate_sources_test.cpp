// SpaceMouse and gamepad, linked to the fakes of libspnav and SDL.
#include <gtest/gtest.h>

#include "master/device/gamepad/gamepad_source.h"
#include "master/device/spacemouse/spacemouse_source.h"
#include "tests/master/device/fakes/fake_library.h"

namespace palpate {
namespace {

constexpr double kSpeed = 0.02;  // [m/s]

// A device that the test polls every 5 ms and reads every millisecond of the fake's clock.
class Bench {
 public:
  Bench(const std::string& folder, const std::string& file) : fake(folder, file) {
    fake.set_clock(0);
  }
  void Use(std::unique_ptr<RateSource> source) {
    device = std::make_unique<RateDevice>(std::move(source), kSpeed, false);
  }
  DeviceReading Run(int ms) {
    DeviceReading reading;
    for (int i = 0; i < ms; ++i) {
      fake.step(0.001);
      const Time now = Time{std::chrono::hours(1)} + Seconds(fake.now());
      if (++ms_ % 5 == 1) device->Poll(now);
      reading = device->Read(now);
      device->WriteForce(force);
    }
    return reading;
  }
  fakes::Library fake;
  std::unique_ptr<RateDevice> device;
  Eigen::Vector3d force{0, 0, 0};

 private:
  int ms_ = 0;
};

// The hand holds the handle at `p`, in the fake's frame [m].
void Hold(const fakes::Library& fake, double x, double y, double z) {
  const FakeKnot knot{0.001, x, y, z};
  fake.follow(&knot, 1);
}

class SpaceMouseTest : public testing::Test {
 protected:
  Bench bench_{"spnav", "libspnav.so"};
};

// Reference: full deflection is full speed for 1 s. The button numbers of a real device have holes.
TEST_F(SpaceMouseTest, MovesWhileAnyFirstButtonIsHeld) {
  bench_.Use(std::make_unique<SpaceMouseSource>());
  Hold(bench_.fake, 0.002, 0, 0.002);
  EXPECT_FALSE(bench_.Run(500).engaged);
  bench_.fake.press(23, 1, 0);
  const Eigen::Vector3d before = bench_.Run(50).p_M;
  const DeviceReading after = bench_.Run(1000);
  EXPECT_TRUE(after.engaged);
  EXPECT_EQ(after.status.buttons, 1U);
  EXPECT_NEAR(after.p_M.x() - before.x(), kSpeed, 0.05 * kSpeed);
  EXPECT_NEAR(after.p_M.z() - before.z(), -kSpeed, 0.05 * kSpeed) << "its z points away";
  bench_.fake.press(2, 1, 0);
  EXPECT_EQ(bench_.Run(20).status.buttons, 3U) << "another button is the second";
  bench_.fake.press(23, 0, 0);
  EXPECT_FALSE(bench_.Run(20).engaged);
}

TEST_F(SpaceMouseTest, UnpluggingEndsTheMotionAndIsReported) {
  bench_.Use(std::make_unique<SpaceMouseSource>());
  Hold(bench_.fake, 0.002, 0, 0);
  bench_.fake.press(23, 1, 0);
  ASSERT_TRUE(bench_.Run(500).engaged);
  bench_.fake.unplug();
  const DeviceReading gone = bench_.Run(10);
  EXPECT_FALSE(gone.engaged);
  EXPECT_EQ(FaultInWords(gone.status), "unplugged: spacenavd reports its removal");
  bench_.fake.replug();
  EXPECT_FALSE(bench_.Run(200).engaged) << "the button was never released";
}

class GamepadTest : public testing::Test {
 protected:
  Bench bench_{"sdl", "libSDL2.so"};
};

// Reference: full deflection is full speed. What a stick reports at rest moves nothing.
TEST_F(GamepadTest, SticksMoveWhileTheSouthButtonIsHeld) {
  bench_.Use(std::make_unique<GamepadSource>());
  bench_.fake.press(0, 1, 0);
  const Eigen::Vector3d before = bench_.Run(500).p_M;
  EXPECT_NEAR(before.norm(), 0, 1e-9) << "drift";
  Hold(bench_.fake, 0.010, 0, 0);
  bench_.Run(50);
  const Eigen::Vector3d from = bench_.Run(1).p_M;
  const DeviceReading after = bench_.Run(1000);
  EXPECT_TRUE(after.engaged);
  EXPECT_NEAR(after.p_M.x() - from.x(), kSpeed, 0.05 * kSpeed);
}

TEST_F(GamepadTest, RumbleShowsTheForceAndEndsWithIt) {
  bench_.Use(std::make_unique<GamepadSource>());
  bench_.Run(20);
  bench_.force = {0, 6, 0};  // half of the largest
  bench_.Run(300);
  double f[3] = {};
  EXPECT_EQ(bench_.fake.last_force(f), 1);
  EXPECT_NEAR(f[0], 0.5, 0.01);
  bench_.Run(2000);
  EXPECT_EQ(bench_.fake.last_force(f), 1) << "it is sent again before it ends";
  bench_.force.setZero();
  bench_.Run(100);
  EXPECT_EQ(bench_.fake.last_force(f), 0);
}

TEST_F(GamepadTest, UnpluggingDisengages) {
  bench_.Use(std::make_unique<GamepadSource>());
  bench_.fake.press(0, 1, 0);
  ASSERT_TRUE(bench_.Run(100).engaged);
  bench_.fake.unplug();
  const DeviceReading gone = bench_.Run(10);
  EXPECT_FALSE(gone.engaged);
  EXPECT_EQ(FaultInWords(gone.status), "unplugged: the game controller is disconnected");
}

}  // namespace
}  // namespace palpate
