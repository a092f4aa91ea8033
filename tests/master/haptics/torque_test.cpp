#include "master/haptics/torque.h"

#include <random>

#include <gtest/gtest.h>

#include "master/device/haptic_device.h"
#include "tests/master/haptics/rig.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

Vector3d AnyOf(std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  return {normal(*random), normal(*random), normal(*random)};
}

TeleopTransform RandomTransform(std::mt19937_64* random) {
  std::uniform_real_distribution<double> scale(0.01, 100);
  TeleopTransform transform;
  transform.position_scale = scale(*random);
  transform.force_scale = scale(*random);
  transform.R_SM = Eigen::AngleAxisd(2, AnyOf(random).normalized()).toRotationMatrix();
  return transform;
}

// Reference: the power of a wrench. The ratio of device to tool is the same for a force with any
// velocity and a moment with any rotation. Rotations follow unscaled: w_S = R_SM w_M.
TEST(TorqueTest, ForceAndTorqueScalePowerAlike) {
  std::mt19937_64 random(12);
  for (int i = 0; i < 1000; ++i) {
    const TeleopTransform transform = RandomTransform(&random);
    const Vector3d f_S = AnyOf(&random), m_S = AnyOf(&random), v_M = AnyOf(&random),
                   w_M = AnyOf(&random);
    const double at_device =
        transform.ForceToMaster(f_S).dot(v_M) + MomentToMaster(transform, m_S).dot(w_M);
    const double at_tool = f_S.dot(transform.VelocityToSlave(v_M)) + m_S.dot(transform.R_SM * w_M);
    const double ratio = transform.force_scale / transform.position_scale;
    ASSERT_NEAR(at_device, ratio * at_tool,
                1e-12 * ratio * (f_S.norm() + m_S.norm()) * (v_M.norm() + w_M.norm()) *
                    (1 + transform.position_scale));
  }
}

TEST(TorqueTest, KeepsTheLeverArmBetweenStates) {
  SlaveState state;
  ForceChain chain;
  chain.force_known = true;
  chain.estimated = {0, 2, 0};
  chain.local = {0, 1, 0};
  chain.scaled = {0, 1, 0};
  chain.sent = {0, 0.5, 0};
  EXPECT_TRUE(TorqueAtDevice(state, chain, {}).isZero(0)) << "unknown is no torque";
  state.moment = Vector3d(0, 0, 0.04);
  EXPECT_EQ(TorqueAtDevice(state, chain, {}), Vector3d(0, 0, 0.01)) << "half, and half of it sent";
  chain.local = {0, 3, 0};
  EXPECT_EQ(TorqueAtDevice(state, chain, {}), Vector3d(0, 0, 0.02)) << "never more than reported";
  chain.local = {0, 0, 0};
  EXPECT_TRUE(TorqueAtDevice(state, chain, {}).isZero(0)) << "the tool has left the surface";
  chain.local = {0, 2, 0};
  for (const double bad : {std::nan(""), 1e300, -HUGE_VAL}) {
    state.moment = Vector3d(bad, 0, 0);
    EXPECT_TRUE(TorqueAtDevice(state, chain, {}).isZero(0));
  }
}

// A driver with three actuated rotations.
class SixAxes final : public HapticDevice {
 public:
  SixAxes() : HapticDevice(Own()) {}
  [[nodiscard]] std::string description() const override { return "six axes"; }
  DeviceReading next;
  Vector3d force{0, 0, 0}, torque{0, 0, 0};

 protected:
  static DeviceCapabilities Own() {
    DeviceCapabilities own;
    own.sensed_dof = own.actuated_dof = 6;
    own.force = 10;
    own.torque = 0.1;
    return own;
  }
  DeviceReading DoRead(Time /*now*/) noexcept override { return next; }
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override {
    force = wrench.force;
    torque = wrench.torque;
    return DeviceOutput::kOk;
  }
};

// Tests the path from the handle to the command and from the state to the actuators. Reference: an
// eccentric contact, m = r x f with r = 10 mm along x, in front of a wall.
TEST(TorqueTest, TheHandleTurnsTheToolAndFeelsItsMoment) {
  HapticLoop::Options options;
  options.slew_limit = 0.2;
  options.sends_orientation = options.renders_torque = true;
  options.motion.axes = AxisMap::Parse("y,-x,z");
  Rig rig(options);
  OperatorCommand sent;
  const Vector3d arm(0.010, 0, 0);
  rig.slave.falsify = [&](SlaveState* state) {
    if (state->force) state->moment = arm.cross(*state->force);
  };
  SixAxes device;
  device.next.q_M = Eigen::AngleAxisd(0.3, Vector3d::UnitX());
  const auto tick = [&] {
    rig.now += kHapticPeriod;
    rig.slave.Step(rig.now, &rig.commands, &rig.states);
    const DeviceReading reading = device.Read(rig.now);
    const Vector3d force = rig.loop.Tick(reading, rig.now);
    device.WriteWrench(force, rig.loop.motion().axes().TorqueToDevice(rig.loop.record().torque));
    if (const auto* command = rig.commands.Take()) {
      sent = *command;
      rig.commands.Put(sent);
    }
    TickRecord drained;
    while (rig.records.Pop(&drained)) {
    }
  };
  for (int i = 0; i < 200; ++i) tick();
  device.next.engaged = true;
  for (int i = 0; i < 300; ++i) tick();
  EXPECT_TRUE(sent.torque);
  ASSERT_TRUE(sent.R_M_device);
  // x of the device is -y of M.
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(0.3, -Vector3d::UnitY()));
  EXPECT_LT(sent.R_M_device->angularDistance(expected), 1e-12);
  // y of M is -x of the device: 8 mm down, 4 mm into the wall of 500 N/m.
  for (int i = 0; i < 800; ++i) {
    device.next.p_M.x() += 1e-5;
    device.next.v_M.x() = 0.01;
    tick();
  }
  device.next.v_M.setZero();
  for (int i = 0; i < 300; ++i) tick();
  EXPECT_NEAR(device.force.x(), -2, 1e-6);
  EXPECT_NEAR(rig.loop.record().torque.z(), 0.02, 1e-6);
  EXPECT_NEAR(device.torque.z(), 0.02, 1e-6);
  EXPECT_LT(device.torque.head<2>().norm(), 1e-12);
  device.next.engaged = false;
  for (int i = 0; i < 100; ++i) tick();
  EXPECT_TRUE(device.torque.isZero(0)) << "with the force";
}

}  // namespace
}  // namespace palpate
