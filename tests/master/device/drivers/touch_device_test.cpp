#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/master/device/drivers/driver_bench.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class TouchDeviceTest : public testing::Test {
 protected:
  void Step(int ms) {
    for (int i = 0; i < ms; ++i) bench_.Step();
  }
  [[nodiscard]] DeviceStatus status() const { return bench_.rig.loop.record().device; }
  DriverBench bench_{TouchBench()};
};

TEST_F(TouchDeviceTest, ReadsMillimetresAsMetresAndTheLimits) {
  bench_.Open();
  bench_.Place({0.01, 0.02, -0.03});
  Step(3);
  EXPECT_NEAR((bench_.rig.loop.record().p_M - Eigen::Vector3d(0.01, 0.02, -0.03)).norm(), 0, 1e-6);
  const DeviceCapabilities& own = bench_.device->capabilities();
  EXPECT_NEAR(own.force, 3.3, 1e-12);
  EXPECT_NEAR(own.continuous_force, 0.88, 1e-12);
  EXPECT_NEAR(own.stiffness, 500, 1e-9);
  EXPECT_NEAR(own.damping, 3, 1e-9);
  EXPECT_NEAR(own.workspace.sizes().x(), 0.16, 1e-9);
  EXPECT_EQ(own.sensed_dof, 6);
  EXPECT_THAT(bench_.device->description(), HasSubstr("Touch, serial 012345678"));
  EXPECT_NEAR(static_cast<double>(status().temperature), 0, 1e-6);
}

TEST_F(TouchDeviceTest, CalibratesInItsInkwellAndHasNoForceBefore) {
  bench_.fake.set_option("calibration", "manual");
  bench_.Open();
  bench_.fake.press(0, 1, 0);
  Step(300);
  EXPECT_EQ(status().calibration, CalibrationState::kManual);
  EXPECT_EQ(status().fault, DeviceFault::kNotCalibrated);
  double f[3];
  EXPECT_EQ(bench_.fake.last_force(f), 0) << "the motors are off";
  EXPECT_NE(bench_.rig.state(), OperatorState::kFollowing);
  bench_.fake.set_option("parked", "1");
  Step(5);
  EXPECT_EQ(status().calibration, CalibrationState::kCalibrated);
  Step(50);
  EXPECT_NE(bench_.rig.state(), OperatorState::kFollowing) << "the button was never released";
  bench_.fake.press(0, 0, 0);
  Step(5);
  bench_.fake.press(0, 1, 0);
  Step(100);
  EXPECT_EQ(bench_.rig.state(), OperatorState::kFollowing);
}

// A device whose encoders reset in a given position is not calibrated before the operator confirms
// that position with the second button.
TEST_F(TouchDeviceTest, AnEncoderResetWaitsForTheSecondButton) {
  bench_.fake.set_option("calibration", "update");
  bench_.fake.set_option("style", "1");
  bench_.Open();
  Step(100);
  EXPECT_EQ(status().calibration, CalibrationState::kManual);
  bench_.fake.press(1, 1, 0);
  Step(5);
  EXPECT_EQ(status().calibration, CalibrationState::kCalibrated);
}

TEST_F(TouchDeviceTest, WarmMotorsEndTheForce) {
  bench_.fake.set_option("heating", "0.05");
  const std::vector<PressTick> press = SimulatedPress();
  bench_.Open();
  bool was_hot = false;
  bench_.Play(press, 2000, [&](std::size_t) {
    if (status().fault != DeviceFault::kHot) return;
    was_hot = true;
    EXPECT_EQ(status().code, 0x200);
    EXPECT_EQ(bench_.Made().norm(), 0);
  });
  EXPECT_TRUE(was_hot);
}

TEST_F(TouchDeviceTest, ErrorsOfTheServoAreFaultsWithTheirCode) {
  bench_.Open();
  Step(10);
  for (const auto& [code, fault] : {std::pair(0x203, DeviceFault::kForceOff),
                                    {0x302, DeviceFault::kSilent},
                                    {0x300, DeviceFault::kDriver},
                                    {0x204, DeviceFault::kDriver}}) {
    bench_.fake.set_error("hdEndFrame", code, 1);
    bench_.Step();
    bench_.Step();
    EXPECT_EQ(status().fault, fault) << code;
    EXPECT_EQ(status().code, code);
    Step(5);
    EXPECT_EQ(status().fault, DeviceFault::kNone);
  }
}

// A failed call leaves its output unchanged. The tool must not move with such a reading.
TEST_F(TouchDeviceTest, AReadingWithAnErrorIsNoPosition) {
  bench_.Open();
  const FakeKnot knot{0.001, 0.01, 0.02, 0.03};
  bench_.fake.follow(&knot, 1);
  Step(10);
  for (const char* function : {"hdGetDoublev", "hdBeginFrame", "hdGetIntegerv"}) {
    bench_.fake.set_error(function, 0x302, 1);
    bench_.Step();
    EXPECT_EQ(status().fault, DeviceFault::kSilent) << function;
    const Eigen::Vector3d& p = bench_.rig.loop.record().p_M;
    EXPECT_NEAR((p - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 0, 1e-6) << function;
    Step(10);
    EXPECT_EQ(status().fault, DeviceFault::kNone);
  }
}

// The library's servo thread runs, and the loop writes no force for 20 ms.
TEST_F(TouchDeviceTest, TheServoDropsTheForceOfASilentLoop) {
  const std::vector<PressTick> press = SimulatedPress();
  bench_.Open();
  bench_.Play(press, 1500);
  ASSERT_GT(bench_.Made().norm(), 0.5);
  bench_.device->StopTicks();
  bench_.fake.step(0.019);
  EXPECT_GT(bench_.Made().norm(), 0.5);
  bench_.fake.step(0.003);
  EXPECT_EQ(bench_.Made().norm(), 0);
}

}  // namespace
}  // namespace palpate
