#include <atomic>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/haptics/tick_drive.h"
#include "tests/master/device/drivers/driver_bench.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class DhdDeviceTest : public testing::Test {
 protected:
  void Step(int ms) {
    for (int i = 0; i < ms; ++i) bench_.Step();
  }
  [[nodiscard]] DeviceStatus status() const { return bench_.rig.loop.record().device; }
  DriverBench bench_{DhdBench()};
};

// A time guard (+1) and an error (-1) of two calls sum to zero. The error counts.
TEST_F(DhdDeviceTest, ATimeGuardNeverCancelsAnError) {
  bench_.Open();
  Step(10);
  bench_.fake.set_error("dhdGetPosition", 1, 1);
  bench_.fake.set_error("dhdGetLinearVelocity", -1, 1);
  bench_.Step();
  EXPECT_EQ(status().fault, DeviceFault::kDriver);
  Step(5);
  EXPECT_EQ(status().fault, DeviceFault::kNone);
  bench_.fake.set_error("dhdGetLinearVelocity", 1, 1);
  bench_.fake.set_error("dhdGetPosition", -1, 1);
  bench_.Step();
  EXPECT_EQ(status().fault, DeviceFault::kDriver);
}

// The controller switches the force off; a new press of the button switches it on.
TEST_F(DhdDeviceTest, AForceThatIsSwitchedOffIsReportedWithItsCause) {
  const std::vector<PressTick> press = SimulatedPress();
  bench_.Open();
  bench_.Play(press, 1500);
  ASSERT_GT(bench_.Made().norm(), 0.5);
  bench_.fake.set_option("deadman", "0");
  Step(30);
  EXPECT_EQ(status().fault, DeviceFault::kForceOff);
  EXPECT_THAT(FaultInWords(status()), HasSubstr("dead-man's switch"));
  EXPECT_EQ(bench_.rig.state(), OperatorState::kClutched);
  bench_.fake.set_option("deadman", "1");
  Step(30);
  EXPECT_EQ(status().fault, DeviceFault::kForceOff) << "nobody enabled it again";
  bench_.fake.press(0, 0, 0);
  Step(5);
  bench_.fake.press(0, 1, 0);
  Step(5);
  EXPECT_EQ(status().fault, DeviceFault::kNone);
  EXPECT_NE(bench_.rig.state(), OperatorState::kFollowing) << "that press only enabled the force";
}

TEST_F(DhdDeviceTest, TheForceIsEnabledOnlyAfterAGoodReading) {
  bench_.Open();
  EXPECT_EQ(bench_.fake.calls("dhdEnableForce"), 0);
  bench_.fake.set_error("dhdGetPosition", -1, 5);
  Step(5);
  EXPECT_EQ(bench_.fake.calls("dhdEnableForce"), 0);
  Step(2);
  EXPECT_EQ(bench_.fake.calls("dhdEnableForce"), 1);
}

TEST_F(DhdDeviceTest, ASigmaSensesSixAxesAndItsClosedGripperEngages) {
  bench_.fake.set_option("model", "sigma.7");
  bench_.Open();
  EXPECT_EQ(bench_.device->capabilities().sensed_dof, 6);
  Step(10);
  EXPECT_EQ(status().buttons & 1U, 0U);
  bench_.fake.set_option("gripper", "0.05");
  Step(100);
  EXPECT_EQ(status().buttons & 1U, 1U);
  EXPECT_EQ(bench_.rig.state(), OperatorState::kFollowing);
}

// Runs in real time with the driver's own thread. A transfer that hangs blocks that thread; the
// loop's thread continues without a reading.
TEST(DhdThreadTest, AHangingTransferEndsForceAndEngagementAndNotTheTicks) {
  const fakes::Library fake("dhd", "libdhd.so");
  const auto device = DhdDevice::Open({std::nullopt, {BinaryPath("/fakes/dhd")}});
  std::atomic<DeviceFault> fault{DeviceFault::kDriver};
  std::atomic<bool> engaged{false};
  TickDrive drive(*device, [&](Time now) {
    const DeviceReading reading = device->Read(now);
    fault = reading.status.fault;
    engaged = reading.engaged;
    device->WriteWrench({1, 0, 0}, {0, 0, 0});
    return true;
  });
  PeriodicStats stats;
  std::jthread loop([&](const std::stop_token& stop) {
    drive.Run(std::chrono::hours(1), stop, &stats);
    drive.Stop();
  });
  // The device must be read once with an open switch before it can engage.
  EXPECT_TRUE(Eventually([&] { return fault == DeviceFault::kNone; }));
  fake.press(0, 1, 0);
  EXPECT_TRUE(Eventually([&] { return engaged.load(); }));
  double force[3] = {};
  EXPECT_TRUE(Eventually([&] { return fake.last_force(force) == 1 && force[1] > 0.9; }));
  fake.set_option("transfer", "1000");
  EXPECT_TRUE(Eventually([&] { return fault == DeviceFault::kSilent && !engaged; }));
  fake.set_option("transfer", "0");
  EXPECT_TRUE(Eventually([&] { return fault == DeviceFault::kNone; }));
  EXPECT_FALSE(engaged) << "the switch was never opened";
}

}  // namespace
}  // namespace palpate
