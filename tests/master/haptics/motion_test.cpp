// The operator's motion settings in the haptic loop, against a virtual slave.
#include <gtest/gtest.h>

#include "master/device/sim_hand.h"
#include "tests/master/haptics/rig.h"

namespace palpate {
namespace {

HapticLoop::Options With(const MotionOptions& motion) {
  HapticLoop::Options options;
  options.slew_limit = kNoSlewLimit;
  options.motion = motion;
  return options;
}

// A device that is mounted with other axes moves the same tool and renders its force. Reference:
// the same run with a device oriented as M.
TEST(LoopMotionTest, MappedAxesChangeNothingForTheOperator) {
  MotionOptions mapped;
  mapped.axes = AxisMap::Parse("-z,x,-y");
  Rig plain(With({})), turned(With(mapped));
  SimHand hand(0.004, 0.02), same(0.004, 0.02);
  // The same motion along the axes of the device.
  struct Turned final : TestDevice {
    Turned(SimHand* own, const AxisMap& axes) : hand(own), P(axes.P()) {}
    DeviceReading Read(Time now) noexcept override {
      DeviceReading reading = hand->Read(now);
      reading.p_M = P.transpose() * reading.p_M;
      reading.v_M = P.transpose() * reading.v_M;
      return reading;
    }
    void WriteWrench(const Eigen::Vector3d& force, const Eigen::Vector3d&) noexcept override {
      hand->WriteForce(P * force);
    }
    void Guide(const DeviceGuide& guide) noexcept override {
      DeviceGuide in_M = guide;
      in_M.inward_M = P * guide.inward_M;
      hand->Guide(in_M);
    }
    SimHand* hand;
    Eigen::Matrix3d P;
  } device(&same, mapped.axes);
  double peak = 0;
  for (int i = 0; i < 6000; ++i) {
    const TickRecord a = plain.Tick(hand), b = turned.Tick(device);
    ASSERT_EQ(a.state, b.state) << i;
    ASSERT_LT((a.p_S - b.p_S).norm(), 1e-15) << i;
    ASSERT_LT((a.chain.sent - b.chain.sent).norm(), 1e-12) << i;
    peak = std::max(peak, a.chain.sent.norm());
  }
  EXPECT_GT(peak, 0.5) << "the operator pressed";
}

// Reference: the slave's tip before the clutch opened. The device moves 30 mm meanwhile.
TEST(LoopMotionTest, TheButtonReindexesWithoutMovingTheTool) {
  MotionOptions motion;
  motion.clutch_button = 2;
  Rig rig(With(motion));
  Puppet puppet;
  rig.Run(puppet, 0.2);
  rig.Engage(puppet, 0.3);
  rig.Glide(puppet, {0, 0.002, 0.001});
  rig.Run(puppet, 0.1);
  ASSERT_EQ(rig.state(), OperatorState::kFollowing);
  const Eigen::Vector3d tip = rig.slave.tip();
  EXPECT_NEAR(tip.z(), 0.001, 1e-9);
  puppet.reading.status.buttons = 0b10;
  rig.Run(puppet, 0.02);
  EXPECT_EQ(rig.state(), OperatorState::kClutched);
  EXPECT_TRUE(rig.loop.record().clutched);
  rig.Glide(puppet, {0.03, 0.002, 0.001});
  EXPECT_EQ(rig.slave.tip(), tip);
  puppet.reading.status.buttons = 0;
  rig.Run(puppet, 0.2);
  EXPECT_EQ(rig.state(), OperatorState::kFollowing) << "the switch was closed all the time";
  EXPECT_LT((rig.slave.tip() - tip).norm(), 1e-12);
  rig.Glide(puppet, {0.03, 0.002, 0.004});
  rig.Run(puppet, 0.1);
  EXPECT_NEAR(rig.slave.tip().z(), 0.004, 1e-9) << "it follows from there";
}

TEST(LoopMotionTest, LocksAndBoxLimitTheTool) {
  MotionOptions motion;
  motion.ParseLocks("x");
  motion.box = Fixture::ParseBox("-5,-1,-5:5,20,5");
  Rig rig(With(motion));
  Puppet puppet;
  rig.Run(puppet, 0.2);
  rig.Engage(puppet, 0.3);
  rig.Glide(puppet, {0.008, -0.003, 0.009});
  rig.Run(puppet, 0.1);
  EXPECT_LT((rig.slave.tip() - Eigen::Vector3d(0, -0.001, 0.005)).norm(), 1e-9);
  EXPECT_TRUE(rig.loop.record().chain.reasons.Has(Reason::kFixture));
  // Springs of 2000 / 2 / 2 = 500 N/m: lock 8 mm; box 2 mm along y and 4 mm along z; at most 3.3 N.
  const Eigen::Vector3d scaled = rig.loop.record().chain.scaled;
  EXPECT_NEAR(scaled.x(), -500 * 0.008, 1e-9);
  EXPECT_NEAR(scaled.y(), 500 * 0.002, 1e-9);
  EXPECT_NEAR(scaled.z(), -500 * 0.004, 1e-9);
  EXPECT_LE(puppet.force.norm(), 3.3 * (1 + 1e-12));
}

}  // namespace
}  // namespace palpate
