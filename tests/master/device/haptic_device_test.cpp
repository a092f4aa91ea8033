#include "master/device/haptic_device.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/device/sim_hand.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

const Time kDeviceStart{std::chrono::hours(1)};
constexpr double kForce = 5, kTorque = 0.1;  // limits of the device

DeviceCapabilities Capabilities() {
  DeviceCapabilities own;
  own.sensed_dof = own.actuated_dof = 6;
  own.force = kForce;
  own.torque = kTorque;
  return own;
}

// A driver that returns the reading set by the test and records the forces that it receives.
class Recorded final : public HapticDevice {
 public:
  explicit Recorded(const DeviceCapabilities& own = Capabilities()) : HapticDevice(own) {}
  [[nodiscard]] std::string description() const override { return "recorded"; }

  DeviceReading next;
  DeviceOutput answer = DeviceOutput::kOk;
  Eigen::Vector3d force{0, 0, 0}, torque{0, 0, 0};  // received last

 protected:
  DeviceReading DoRead(Time /*now*/) noexcept override { return next; }
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override {
    force = wrench.force;
    torque = wrench.torque;
    return answer;
  }
};

class HapticDeviceTest : public testing::Test {
 protected:
  // A tick with a step of `ms`.
  DeviceStatus Tick(const Eigen::Vector3d& force, int ms = 1,
                    const Eigen::Vector3d& torque = {0, 0, 0}) {
    now_ += std::chrono::milliseconds(ms);
    reading_ = device_.Read(now_);
    device_.WriteWrench(force, torque);
    return device_.status();
  }

  Recorded device_;
  Time now_ = kDeviceStart;
  DeviceReading reading_;
};

// A torque that always drives the handle on. Reference: the credit of 0.5 mJ is used up after
// 0.1 N m x 5 mrad, and then only the work of a tick, 0.1 mJ, is added.
TEST_F(HapticDeviceTest, TheTorqueReturnsNoMoreEnergyThanItReceivedPlusTheCredit) {
  device_.next.engaged = true;
  double received = 0;
  for (int i = 0; i < 1000; ++i) {
    received += device_.torque.z() * 0.001;  // the operator turns at 1 rad/s
    device_.next.q_M = Eigen::AngleAxisd(0.001 * i, Eigen::Vector3d::UnitZ());
    Tick({0, 0, 0}, 1, {0, 0, kTorque});
  }
  EXPECT_GT(received, 0.4e-3);
  EXPECT_LT(received, 0.5e-3 + 2 * kTorque * 0.001);
  EXPECT_NEAR(device_.torque.z(), 0, 1e-12);
}

TEST_F(HapticDeviceTest, WithoutAMeasuredOrientationThereIsNoTorque) {
  DeviceCapabilities own = Capabilities();
  own.sensed_dof = 3;
  Recorded blind(own);
  EXPECT_EQ(blind.limits().torque, 0);
  for (int i = 1; i < 100; ++i) {
    blind.Read(kDeviceStart + std::chrono::milliseconds(i));
    blind.WriteWrench({0, 0, 0}, {0, 0, 1});
    EXPECT_TRUE(blind.torque.isZero(0));
  }
}

TEST_F(HapticDeviceTest, AnOrientationThatIsNoRotationIsAFault) {
  for (const double w : {0.0, 2.0, std::nan("")}) {
    device_.next.q_M = Eigen::Quaterniond(w, 0, 0, 0);
    EXPECT_EQ(Tick({1, 0, 0}).fault, DeviceFault::kImpossible) << w;
  }
  device_.next.q_M = Eigen::Quaterniond(1.005, 0, 0, 0);
  EXPECT_EQ(Tick({1, 0, 0}).fault, DeviceFault::kNone);
  EXPECT_NEAR(reading_.q_M.norm(), 1, 1e-15) << "rounding is removed";
}

TEST_F(HapticDeviceTest, AfterAFaultTheSwitchMustOpenFirst) {
  device_.next.engaged = true;
  Tick({0, 0, 0});
  EXPECT_TRUE(reading_.engaged);
  device_.next.status.fault = DeviceFault::kUnplugged;
  Tick({0, 0, 0});
  EXPECT_FALSE(reading_.engaged);
  device_.next.status.fault = DeviceFault::kNone;
  for (int i = 0; i < 50; ++i) Tick({0, 0, 0});
  EXPECT_FALSE(reading_.engaged) << "the operator never let go";
  device_.next.engaged = false;
  Tick({0, 0, 0});
  device_.next.engaged = true;
  Tick({0, 0, 0});
  EXPECT_TRUE(reading_.engaged);
}

// Also tests the base class of all drivers and the simulated operator.
TEST(HapticDeviceAllocationTest, ReadingAndWritingDoNotAllocate) {
  Recorded recorded;
  SimHand hand(0.004, 0.02);
  const long before = AllocationCount();
  for (int i = 0; i < 1000; ++i) {
    const Time now = kDeviceStart + std::chrono::milliseconds(i);
    recorded.next.status.fault = i % 100 == 50 ? DeviceFault::kDriver : DeviceFault::kNone;
    for (HapticDevice* device :
         {static_cast<HapticDevice*>(&recorded), static_cast<HapticDevice*>(&hand)}) {
      device->Read(now);
      device->WriteWrench({1, 2, 3}, {0, 0, 1});
    }
  }
  EXPECT_EQ(AllocationCount(), before);
}

// Random readings, faults, forces and steps: the driver never gets a force above the limit or one
// that rises faster than allowed, and gets no force without a calibrated, new and valid reading.
TEST(HapticDevicePropertyTest, NoOrderOfCallsSkipsALimit) {
  std::mt19937_64 random(20261125);
  const auto below = [&random](int n) {
    return static_cast<int>(random() % static_cast<unsigned>(n));
  };
  int with_force = 0, without = 0;
  for (int round = 0; round < 200; ++round) {
    Recorded device;
    double limit = kForce;
    Time now = kDeviceStart, written{}, fresh{};
    Eigen::Vector3d last(0, 0, 0), last_torque(0, 0, 0);
    bool usable = false;
    for (int i = 0; i < 500; ++i) {
      const int kind = below(20);
      device.next.repeated = below(3) == 0 || (i / 50) % 4 == 3;
      device.next.engaged = below(2) == 0;
      device.next.status.calibration =
          below(30) == 0 ? CalibrationState::kManual : CalibrationState::kCalibrated;
      device.next.status.fault = below(60) == 0 ? DeviceFault::kDriver : DeviceFault::kNone;
      device.next.p_M.x() = below(80) == 0 ? std::nan("") : 0.01;
      device.answer = static_cast<DeviceOutput>(below(3));
      if (kind == 0) {
        const double wanted = 1.0 + below(6);
        limit = std::min(limit, wanted);
        device.LowerForceLimit(wanted);
      }
      if (kind == 1) device.DropForce(), last.setZero(), last_torque.setZero();
      if (kind != 2) {
        now += std::chrono::microseconds(100 + below(4000));
        const DeviceReading reading = device.Read(now);
        const bool good = device.next.status.fault == DeviceFault::kNone &&
                          IsUsable(device.next.status.calibration) &&
                          std::isfinite(device.next.p_M.x());
        if (device.next.status.fault == DeviceFault::kNone && !device.next.repeated) fresh = now;
        usable = good && fresh != Time{} && SecondsBetween(fresh, now) < 0.020;
        ASSERT_EQ(reading.status.fault == DeviceFault::kNone, usable) << round << " " << i;
        if (!usable) {
          ASSERT_TRUE(device.force.isZero(0) && device.torque.isZero(0));
          last.setZero(), last_torque.setZero();
        }
        ASSERT_TRUE(usable || !reading.engaged);
      }
      const double size = std::pow(10.0, below(6) - 2);
      const Eigen::Vector3d wanted(size * (below(3) - 1), size * (below(3) - 1),
                                   below(50) == 0 ? NAN : size);
      device.WriteWrench(wanted, wanted);
      const double step = 200 * std::min(0.001, SecondsBetween(written, now));
      ASSERT_TRUE(device.force.allFinite() && device.torque.allFinite());
      ASSERT_LE(device.force.norm(), std::max(limit, (last).norm()) * (1 + 1e-8));
      ASSERT_LE(device.torque.norm(), kTorque * (1 + 1e-8));
      if (!usable) {
        ASSERT_TRUE(device.force.isZero(0) && device.torque.isZero(0)) << round << " " << i;
        ASSERT_EQ(device.status().output, DeviceOutput::kOff);
      }
      ASSERT_LE((device.force - last).norm(), step * (1 + 1e-8) + 1e-15) << round << " " << i;
      ASSERT_LE((device.torque - last_torque).norm(), step * kTorque / kForce * (1 + 1e-8) + 1e-15);
      (device.force.isZero(0) ? without : with_force) += 1;
      last = device.force;
      last_torque = device.torque;
      if (now != kDeviceStart) written = now;  // before a reading there is no time
    }
  }
  EXPECT_GT(with_force, 20000) << "the test did not exercise forces";
  EXPECT_GT(without, 5000);
}

}  // namespace
}  // namespace palpate
