#include "slave/live/operator_port.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/live/arm_sequence.h"
#include "tests/support/dice.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Reaches its target at once.
class PerfectManipulator : public Manipulator {
 public:
  bool Command(const Vector3d& p_S_target) noexcept override {
    if (moves) tip_ = p_S_target;
    target = p_S_target;
    ++commands_;
    return true;
  }
  void Hold() noexcept override {
    ++holds_;
    stopped = false;
  }
  void Turn(const Eigen::Quaterniond& R_S_target) noexcept override {
    if (rotation) rotation = R_S_target;
    ++turns;
  }
  [[nodiscard]] std::optional<Eigen::Quaterniond> Rotation() const noexcept override {
    return rotation;
  }
  [[nodiscard]] Vector3d Tip() const noexcept override { return tip_; }
  [[nodiscard]] std::uint32_t frame() const noexcept override { return driver; }
  [[nodiscard]] bool at_limit() const noexcept override { return false; }
  [[nodiscard]] bool carries_tool() const noexcept override { return true; }
  void Stop() noexcept override {
    ++holds_;
    stopped = true;
  }
  [[nodiscard]] bool is_faulty() const noexcept override { return faulty; }
  void Place(const Vector3d& p_S) { tip_ = p_S; }
  bool faulty = false, stopped = false;
  bool moves = true;
  std::uint32_t driver = 1;
  Vector3d target{0, 0, 0};
  std::optional<Eigen::Quaterniond> rotation;
  int turns = 0;
  [[nodiscard]] int commands() const { return commands_; }
  [[nodiscard]] int holds() const { return holds_; }

 private:
  Vector3d tip_{0.01, 0.02, 0};
  int commands_ = 0, holds_ = 0;
};

class OperatorPortTest : public ::testing::Test {
 protected:
  OperatorPortTest() { port_.BeginOperating(); }

  OperatorCommand Next(const Vector3d& p_M, bool engaged = true, std::uint32_t epoch = 1) {
    OperatorCommand command;
    command.sequence = ++sequence_;
    command.epoch = epoch;
    command.p_M = p_M;
    command.engaged = engaged;
    return command;
  }
  bool Send(const OperatorCommand& command) { return port_.Command(command, now_); }
  void Wait(double seconds, const ContactState& contact = {Vector3d::Zero()}) {
    now_ += Seconds(seconds);
    port_.Watch(now_, contact);
  }

  PerfectManipulator arm_;
  TeleopTransform transform_{0.5, 2.0, Eigen::Matrix3d::Identity(), Vector3d::Zero()};
  ManipulatorOptions limits_{.max_speed = 10};
  OperatorPort port_{arm_, transform_, limits_};
  Time now_ = Time{} + Seconds(100);
  std::uint64_t sequence_ = 0;
};

TEST_F(OperatorPortTest, EngagingMovesNothingAndMotionIsScaled) {
  const Vector3d start = arm_.Tip();
  Send(Next({0.3, -0.1, 0}));
  EXPECT_LT((arm_.Tip() - start).norm(), 1e-15);
  Send(Next({0.3, -0.12, 0}));
  EXPECT_LT((arm_.Tip() - start - Vector3d(0, -0.01, 0)).norm(), 1e-15);
  EXPECT_EQ(port_.view().phase, Phase::kFollowing);
}

Eigen::Quaterniond AnyRotation(Dice* dice) {
  return Eigen::Quaterniond(dice->Normal(), dice->Normal(), dice->Normal(), dice->Normal())
      .normalized();
}

// Law: R_S_tool = R_SM R_M(t) R_M(0)^T R_SM^T R_S_tool(0), and p_S in proportion to p_M.
TEST_F(OperatorPortTest, RotationsFollowRelativeToTheEngagementInTheFrameOfTheSlave) {
  Dice dice(3);
  transform_.R_SM = AnyRotation(&dice).toRotationMatrix();
  OperatorPort port(arm_, transform_, limits_);
  port.BeginOperating();
  const Eigen::Quaterniond R_S0 = AnyRotation(&dice), R_M0 = AnyRotation(&dice);
  arm_.rotation = R_S0;
  OperatorCommand command = Next({0, 0, 0});
  command.R_M_device = R_M0;
  EXPECT_TRUE(port.Command(command, now_));
  EXPECT_LT(arm_.rotation->angularDistance(R_S0), 1e-7) << "engaging turned the tool";
  for (int i = 0; i < 50; ++i) {
    const Eigen::Quaterniond R_M = AnyRotation(&dice);
    command = Next({0, 0, 0});
    command.R_M_device = R_M;
    EXPECT_TRUE(port.Command(command, now_));
    const Eigen::Matrix3d turned = transform_.R_SM * (R_M * R_M0.conjugate()).toRotationMatrix() *
                                   transform_.R_SM.transpose() * R_S0.toRotationMatrix();
    EXPECT_LT((arm_.rotation->toRotationMatrix() - turned).norm(), 1e-12);
  }
}

// Law: whatever the device does while the clutch is open, or in another epoch, letting go and
// engaging neither moves nor turns the slave.
TEST_F(OperatorPortTest, ClutchingNeitherMovesNorTurnsTheSlave) {
  Dice dice(11);
  arm_.rotation = AnyRotation(&dice);
  std::uint32_t epoch = 1;
  Vector3d p_M(0, 0, 0);
  Eigen::Quaterniond R_M = AnyRotation(&dice);
  for (int i = 0; i < 3000; ++i) {
    const Vector3d tip = arm_.Tip();
    const Eigen::Quaterniond rotation = *arm_.rotation;
    const bool clutches = dice.Chance(0.3);
    OperatorCommand command;
    if (clutches) {  // the hand goes anywhere, with or without commands
      if (dice.Chance(0.5)) Send(Next(p_M, false, epoch));
      if (dice.Chance(0.2)) Wait(dice.Between(0.01, 0.5));
      p_M = {dice.Normal(), dice.Normal(), dice.Normal()};
      R_M = AnyRotation(&dice);
      command = Next(p_M, true, ++epoch);
    } else {
      p_M += Vector3d(dice.Normal(), dice.Normal(), dice.Normal()) * 1e-3;
      R_M = Eigen::AngleAxisd(0.1 * dice.Normal(), Vector3d::UnitY()) * R_M;
      command = Next(p_M, true, epoch);
    }
    command.R_M_device = R_M;
    if (dice.Chance(0.5)) command.R_M_device->coeffs() *= -1;
    ASSERT_TRUE(Send(command));
    if (!clutches) continue;
    EXPECT_LT((arm_.Tip() - tip).norm(), 1e-12);
    EXPECT_LT(arm_.rotation->angularDistance(rotation), 1e-7);
  }
  EXPECT_GT(arm_.turns, 2000);
}

TEST_F(OperatorPortTest, WhatHoldsTheTipHoldsTheRotation) {
  arm_.rotation = Eigen::Quaterniond::Identity();
  OperatorCommand command = Next({0, 0, 0});
  command.R_M_device = Eigen::Quaterniond::Identity();
  Send(command);
  Wait(0.031);  // silence
  ASSERT_EQ(port_.view().phase, Phase::kHold);
  const int turns = arm_.turns;
  Wait(0.3);
  command = Next({0, 0, 0});  // the same epoch is not served again
  command.R_M_device = Eigen::AngleAxisd(0.5, Vector3d::UnitX());
  Send(command);
  EXPECT_EQ(arm_.turns, turns);
  command.engaged = false;
  command.sequence = ++sequence_;
  Send(command);
  EXPECT_EQ(arm_.turns, turns);
}

// The first command of an engagement that has a rotation is where it counts from.
TEST_F(OperatorPortTest, ADeviceThatBeginsToMeasureItsRotationTurnsNothing) {
  arm_.rotation = Eigen::Quaterniond::Identity();
  Send(Next({0, 0, 0}));
  EXPECT_EQ(arm_.turns, 0);
  OperatorCommand command = Next({0, 0, 0});
  command.R_M_device = Eigen::AngleAxisd(2, Vector3d::UnitZ());
  Send(command);
  EXPECT_LT(arm_.rotation->angularDistance(Eigen::Quaterniond::Identity()), 1e-7);
}

TEST_F(OperatorPortTest, ARotationThatIsNotFiniteIsRefusedAndTheToolHolds) {
  Send(Next({0, 0, 0}));
  OperatorCommand command = Next({0, 0, 0});
  command.R_M_device = Eigen::Quaterniond(1, 0, std::nan(""), 0);
  EXPECT_FALSE(Send(command));
  EXPECT_EQ(port_.view().phase, Phase::kHold);
  EXPECT_TRUE(port_.TakeEvents().Has(Event::kCommandRefused));
}

TEST_F(OperatorPortTest, AnOlderCommandIsDropped) {
  Send(Next({0, 0, 0}));
  const OperatorCommand old = Next({0, 0.5, 0});
  const OperatorCommand newest = Next({0, 0.001, 0});
  Send(newest);
  const Vector3d tip = arm_.Tip();
  const auto taken = port_.counts().taken;
  EXPECT_TRUE(Send(old));
  EXPECT_TRUE(Send(newest)) << "repeated";
  EXPECT_EQ(arm_.Tip(), tip);
  EXPECT_EQ(port_.counts().taken, taken);
}

TEST_F(OperatorPortTest, SilenceHoldsTheToolAfterThirtyMilliseconds) {
  Send(Next({0, 0, 0}));
  Wait(0.029);
  EXPECT_EQ(port_.view().phase, Phase::kFollowing);
  const int holds = arm_.holds();
  Wait(0.002);
  EXPECT_EQ(port_.view().phase, Phase::kHold);
  EXPECT_GT(arm_.holds(), holds);
  EXPECT_TRUE(port_.TakeEvents().Has(Event::kHold));
}

TEST_F(OperatorPortTest, AnArmWithAFaultIsHeldAndItsReturnNeedsAnEngagement) {
  Send(Next({0, 0, 0}));
  Send(Next({0, -0.002, 0}));
  arm_.faulty = true;
  Wait(0.002);
  EXPECT_EQ(port_.view().phase, Phase::kHold);
  EXPECT_TRUE(port_.TakeEvents().Has(Event::kHold));
  const int commands = arm_.commands();
  Send(Next({0, -0.004, 0}));
  Send(Next({0, -0.004, 0}, true, 2));  // engaging meanwhile is used up
  arm_.faulty = false;
  Wait(0.002);
  Send(Next({0, -0.004, 0}, true, 2));
  EXPECT_EQ(port_.view().phase, Phase::kHold);
  EXPECT_EQ(arm_.commands(), commands);
  const Vector3d tip = arm_.Tip();
  Send(Next({0, -0.004, 0}, true, 3));
  EXPECT_EQ(port_.view().phase, Phase::kFollowing);
  EXPECT_LT((arm_.Tip() - tip).norm(), 1e-15);
}

TEST_F(OperatorPortTest, TheEmergencyStopIsTheArmsOwn) {
  Send(Next({0, 0, 0}));
  port_.EmergencyStop();
  EXPECT_TRUE(arm_.stopped);
  port_.EndOperating();
  port_.BeginOperating();
  EXPECT_TRUE(arm_.stopped) << "whoever comes and goes, it stays stopped";
  port_.Reset(port_.stops());
  EXPECT_FALSE(arm_.stopped);
}

TEST_F(OperatorPortTest, AShortSilenceEndsByItselfALongOneNeedsANewEpoch) {
  Send(Next({0, 0, 0}));
  Wait(0.1);
  Send(Next({0, 0, 0}));
  EXPECT_EQ(port_.view().phase, Phase::kFollowing);
  Wait(0.3);
  Send(Next({0, -0.01, 0}));
  EXPECT_EQ(port_.view().phase, Phase::kHold);
  Send(Next({0, -0.01, 0}, true, 2));
  EXPECT_EQ(port_.view().phase, Phase::kFollowing);
}

TEST_F(OperatorPortTest, BrokenNumbersAreRefusedAndHoldTheTool) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Send(Next({0, 0, 0}));
  const Vector3d tip = arm_.Tip();
  int refused = 0;
  for (const Vector3d& bad : {Vector3d(nan, 0, 0), Vector3d(0, 1e300, 0), Vector3d(0, 0, -101),
                              Vector3d(0, std::numeric_limits<double>::infinity(), 0)}) {
    EXPECT_FALSE(Send(Next(bad))) << bad.transpose();
    EXPECT_EQ(port_.counts().refused, static_cast<std::uint64_t>(++refused));
    EXPECT_EQ(arm_.Tip(), tip);
    EXPECT_EQ(port_.view().phase, Phase::kHold);
  }
  OperatorCommand fast = Next({0, 0, 0});
  fast.velocity = {0, 1e9, 0};
  EXPECT_FALSE(Send(fast));
  OperatorCommand no_epoch = Next({0, 0, 0}, true, 0);
  EXPECT_FALSE(Send(no_epoch));
  EXPECT_TRUE(port_.TakeEvents().Has(Event::kCommandRefused));
}

// As the .proto has it: an epoch begins with an engagement, so before the first there may be none.
TEST_F(OperatorPortTest, AnOpenClutchNeedsNoEpochAndHoldsInAny) {
  EXPECT_TRUE(Send(Next({0, 0, 0}, false, 0)));
  EXPECT_EQ(port_.view().phase, Phase::kClutched);
  EXPECT_FALSE(port_.TakeEvents().Has(Event::kCommandRefused));
  Send(Next({0, 0, 0}, true, 3));
  EXPECT_TRUE(Send(Next({0, 0.1, 0}, false, 2)));
  EXPECT_EQ(port_.view().phase, Phase::kClutched) << "whoever lets go is believed";
  EXPECT_EQ(port_.view().epoch, 3U);
}

TEST_F(OperatorPortTest, AnEpochThatGoesBackIsRefusedAndHoldsTheTool) {
  Send(Next({0, 0, 0}, true, 5));
  const Vector3d tip = arm_.Tip();
  EXPECT_FALSE(Send(Next({0, -0.1, 0}, true, 4)));
  EXPECT_EQ(port_.view().phase, Phase::kHold);
  EXPECT_EQ(arm_.Tip(), tip);
  EXPECT_TRUE(port_.TakeEvents().Has(Event::kCommandRefused));
  Send(Next({0, -0.002, 0}, true, 5));
  EXPECT_EQ(port_.view().phase, Phase::kFollowing);
}

TEST_F(OperatorPortTest, TheEmergencyStopIsLatchedUntilReset) {
  Send(Next({0, 0, 0}));
  port_.EmergencyStop();
  const Vector3d tip = arm_.Tip();
  Send(Next({0, -0.1, 0}, true, 2));
  port_.EndOperating();
  port_.BeginOperating();
  sequence_ = 0;
  Send(Next({0, -0.1, 0}, true, 1));
  EXPECT_EQ(port_.view().phase, Phase::kEstop);
  EXPECT_EQ(arm_.Tip(), tip);
  port_.Reset(port_.stops());
  Send(Next({0, -0.1, 0}, true, 1));
  EXPECT_EQ(arm_.Tip(), tip) << "after a reset the operator engages anew";
  Send(Next({0, -0.1, 0}, true, 2));
  EXPECT_EQ(port_.view().phase, Phase::kFollowing);
  EXPECT_LT((arm_.Tip() - tip).norm(), 1e-15);
}

// A reset first removes the record of the stop, which may wait for the disk.
TEST_F(OperatorPortTest, AStopThatArrivesDuringAResetRemains) {
  port_.EmergencyStop();
  const std::uint64_t stops = port_.stops();
  port_.EmergencyStop();
  EXPECT_FALSE(port_.Reset(stops));
  EXPECT_EQ(port_.view().phase, Phase::kEstop);
  EXPECT_TRUE(port_.Reset(port_.stops()));
  EXPECT_NE(port_.view().phase, Phase::kEstop);
}

TEST_F(OperatorPortTest, ScalesChangeOnlyWhileNobodyFollows) {
  Send(Next({0, 0, 0}));
  EXPECT_THROW(port_.SetScales(2.0, std::nullopt), std::logic_error);
  Send(Next({0, 0, 0}, false));
  port_.SetScales(2.0, 3.0);
  EXPECT_EQ(port_.transform().position_scale, 2.0);
  EXPECT_EQ(port_.transform().force_scale, 3.0);
}

TEST_F(OperatorPortTest, AScaleChangedInAShortSilenceNeedsANewEpoch) {
  Send(Next({0, -0.1, 0}));
  const Vector3d tip = arm_.Tip();
  Wait(0.1);
  port_.SetScales(5.0, std::nullopt);
  Send(Next({0, -0.2, 0}));
  EXPECT_EQ(arm_.Tip(), tip);
  EXPECT_EQ(port_.view().phase, Phase::kHold);
  Send(Next({0, -0.2, 0}, true, 2));
  EXPECT_EQ(port_.view().phase, Phase::kFollowing);
  EXPECT_LT((arm_.Tip() - tip).norm(), 1e-15);
}

// Reference: W = F d, the work done against a constant force of the object.
TEST_F(OperatorPortTest, EnergyIsForceTimesWay) {
  Send(Next({0, 0, 0}));
  const Vector3d force(0, 2, 0);
  port_.Watch(now_, {force});
  Send(Next({0, -0.02, 0}));  // 1 cm at the tool, against the force
  port_.Watch(now_, {force});
  EXPECT_NEAR(port_.view().energy_in, 0.02, 1e-12);
  Send(Next({0, -0.01, 0}));
  port_.Watch(now_, {force});
  EXPECT_NEAR(port_.view().energy_in, 0.02, 1e-12);
  EXPECT_NEAR(port_.view().energy_out, 0.01, 1e-12);
}

// 20 mm/s: 4 mm in the 0.2 s that a command may lead.
class GuardedPortTest : public OperatorPortTest {
 protected:
  GuardedPortTest() { Use({.max_speed = 0.020}); }
  void Use(const ManipulatorOptions& limits) {
    guarded_.emplace(arm_, TeleopTransform(), limits);
    guarded_->BeginOperating();
    guarded_->Watch(now_, {Vector3d::Zero()});
    EXPECT_TRUE(Send(Next({0, 0, 0})));
  }
  bool Send(const OperatorCommand& command) { return guarded_->Command(command, now_); }
  // At 2 mm/s down for `seconds`, with the force estimated meanwhile.
  void Press(double seconds, const ContactState& contact) {
    for (double t = 0; t < seconds; t += 0.002) {
      now_ += Seconds(0.002);
      y_ -= 4e-6;
      Send(Next({0, y_, 0}, true, epoch_));
      guarded_->Watch(now_, contact);
    }
  }
  Phase phase() const { return guarded_->view().phase; }

  std::optional<OperatorPort> guarded_;
  double y_ = 0;
  std::uint32_t epoch_ = 1;
};

TEST_F(GuardedPortTest, ALeapBeyondTheArmIsRefusedAndNeedsANewEngagement) {
  const Vector3d tip = arm_.Tip();
  EXPECT_TRUE(Send(Next({0, -0.0035, 0})));
  EXPECT_FALSE(Send(Next({0, -0.020, 0})));
  EXPECT_LT((arm_.Tip() - tip).norm(), 0.004);
  EXPECT_EQ(phase(), Phase::kHold);
  EXPECT_TRUE(guarded_->TakeEvents().Has(Event::kCommandRefused));
  EXPECT_TRUE(Send(Next({0, -0.0035, 0})));
  EXPECT_EQ(phase(), Phase::kHold) << "not in the old epoch";
  EXPECT_TRUE(Send(Next({0, -0.020, 0}, true, 2)));
  EXPECT_EQ(phase(), Phase::kFollowing);
  EXPECT_FALSE(Send(Next({0, -99, 0}, true, 2))) << "100 m are a number, and no place";
}

TEST_F(GuardedPortTest, MotionEndsWhenTheForceHasBeenUnknownForTooLong) {
  Press(0.240, {std::nullopt});
  EXPECT_EQ(phase(), Phase::kFollowing);
  Press(0.030, {std::nullopt});
  EXPECT_EQ(phase(), Phase::kHold);
  EXPECT_TRUE(guarded_->TakeEvents().Has(Event::kHold));
  const Vector3d tip = arm_.Tip();
  epoch_ = 2;
  Press(0.020, {std::nullopt});
  EXPECT_EQ(phase(), Phase::kHold) << "engaging anew makes nothing known";
  EXPECT_LT((arm_.Tip() - tip).norm(), 1e-4);
}

// Whoever opens an epoch before each step moves nothing either, nor whoever comes again.
TEST_F(GuardedPortTest, NeitherEpochsNorANewLeaseMoveABlindTool) {
  Press(0.270, {std::nullopt});
  const Vector3d tip = arm_.Tip();
  const auto creep = [&] {
    for (int step = 0; step < 20; ++step) {
      ++epoch_;
      EXPECT_TRUE(Send(Next({0, 0, 0}, true, epoch_)));
      Send(Next({0, -0.0035, 0}, true, epoch_));
      if (step % 5 == 4) guarded_->Watch(now_ += Seconds(0.002), {std::nullopt});
    }
  };
  creep();
  EXPECT_EQ(phase(), Phase::kHold);
  guarded_->EndOperating();
  guarded_->BeginOperating();
  creep();
  EXPECT_EQ(arm_.Tip(), tip);
  guarded_->Watch(now_, {Vector3d::Zero()});
  EXPECT_TRUE(Send(Next({0, 0, 0}, true, ++epoch_)));
  EXPECT_EQ(phase(), Phase::kFollowing) << "a known force lets the tool follow again";
}

TEST_F(GuardedPortTest, AGuardStaysWhileTheForceIsUnknown) {
  Use({.max_speed = 0.020, .force_guard = 2});
  Press(0.004, {Vector3d(0, 2.1, 0), 1e-3, {0, 1, 0}});
  EXPECT_EQ(phase(), Phase::kHold);
  const double held = arm_.Tip().y();
  epoch_ = 2;
  Press(0.1, {std::nullopt});
  EXPECT_NEAR(arm_.Tip().y(), held, 1e-5);
}

TEST_F(GuardedPortTest, AForceBeyondTheGuardHoldsUntilTheToolIsDrawnBack) {
  Use({.max_speed = 0.020, .force_guard = 2});
  const ContactState light{Vector3d(0, 1.9, 0), 1e-3, {0, 1, 0}},
      heavy{Vector3d(0, 2.1, 0), 1e-3, {0, 1, 0}};
  Press(0.1, light);
  EXPECT_EQ(phase(), Phase::kFollowing);
  Press(0.004, heavy);
  EXPECT_EQ(phase(), Phase::kHold);
  EXPECT_TRUE(guarded_->TakeEvents().Has(Event::kLimit));
  const double held = arm_.Tip().y();
  epoch_ = 2;
  Press(0.1, heavy);
  EXPECT_NEAR(arm_.Tip().y(), held, 1e-5) << "no deeper";
  Send(Next({0, 0, 0}, true, 3));
  Send(Next({0, 0.002, 0}, true, 3));
  EXPECT_NEAR(arm_.Tip().y(), held + 0.002, 1e-5) << "back is free";
  EXPECT_EQ(phase(), Phase::kFollowing);
}

TEST_F(GuardedPortTest, ADepthBeyondTheGuardRetractsToTheSurfaceWhereTheSceneSaysSo) {
  Use({.max_speed = 0.020, .depth_guard = 2e-3, .guard_retracts = true});
  Press(0.1, {Vector3d(0, 1, 0), 1.9e-3, {0, 1, 0}});
  EXPECT_EQ(phase(), Phase::kFollowing);
  arm_.moves = false;  // it takes its time
  const double deepest = arm_.Tip().y();
  Press(0.004, {Vector3d(0, 1, 0), 2.1e-3, {0, 1, 0}});
  EXPECT_EQ(phase(), Phase::kHold);
  EXPECT_NEAR(arm_.target.y(), deepest + 2.1e-3, 1e-5);
  const int holds = arm_.holds();
  epoch_ = 2;
  Press(0.02, {Vector3d(0, 1, 0), 2.1e-3, {0, 1, 0}});
  EXPECT_EQ(arm_.holds(), holds) << "it goes on back, whatever the operator says";
  guarded_->EmergencyStop();
  EXPECT_GT(arm_.holds(), holds) << "but for the emergency stop";
}

class RetreatTest : public GuardedPortTest {
 protected:
  RetreatTest() {
    Use({.max_speed = 0.020, .force_guard = 2, .guard_retracts = true});
    Press(0.1, light_);
    deepest_ = arm_.Tip().y();
  }
  void Watch(double seconds, const ContactState& contact) {
    for (double t = 0; t < seconds; t += 0.002) guarded_->Watch(now_ += Seconds(0.002), contact);
  }
  // By how far the tool came out of where it was deepest [m].
  double Out() const { return arm_.Tip().y() - deepest_; }
  void LetGo() { Send(Next({0, y_, 0}, false, epoch_)); }

  const ContactState light_{Vector3d(0, 1, 0), 1e-3, {0, 1, 0}};
  const ContactState heavy_{Vector3d(0, 2.1, 0), 2e-3, {0, 1, 0}};
  double deepest_ = 0;
};

// An arm with a fault stops and forgets its target.
TEST_F(RetreatTest, AFaultDelaysItAndLocksNobodyOut) {
  arm_.faulty = true;
  arm_.moves = false;
  Watch(0.15, heavy_);
  EXPECT_NEAR(Out(), 0, 1e-9);
  arm_.faulty = false;
  arm_.moves = true;
  Watch(0.01, heavy_);
  EXPECT_NEAR(Out(), 2e-3, 1e-9);
  Watch(0.01, {Vector3d::Zero()});
  Send(Next({0, 0, 0}, true, 2));
  Send(Next({0, 0.001, 0}, true, 2));
  EXPECT_NEAR(Out(), 3e-3, 1e-9) << "whoever engages anew leads it";
}

// It counts from another place: what was out for the last one is 30 mm deeper for this one.
TEST_F(RetreatTest, AnotherDriverIsNotLedByThePlacesOfTheLast) {
  arm_.moves = false;
  Watch(0.01, heavy_);
  arm_.faulty = true;
  Watch(0.05, heavy_);
  arm_.faulty = false;
  arm_.moves = true;
  ++arm_.driver;
  arm_.Place({0.01, 0.03, 0});
  Watch(1, heavy_);
  EXPECT_EQ(arm_.Tip().y(), 0.03);
  EXPECT_EQ(phase(), Phase::kHold);
}

TEST_F(RetreatTest, AnArmThatDoesNotComeAllTheWayLocksNobodyOut) {
  Press(0.002, heavy_);
  arm_.moves = false;
  arm_.Place({0.01, deepest_ + 1e-3, 0});
  Watch(3, heavy_);
  arm_.moves = true;
  Send(Next({0, 0, 0}, true, 2));
  Send(Next({0, 0.002, 0}, true, 2));
  EXPECT_EQ(phase(), Phase::kFollowing);
  EXPECT_NEAR(Out(), 3e-3, 1e-9);
}

TEST_F(RetreatTest, ItBeginsAlsoAfterTheHandLetGo) {
  LetGo();
  Watch(0.03, heavy_);
  EXPECT_NEAR(Out(), 2e-3, 1e-9);
}

TEST_F(RetreatTest, ItBeginsWhenWhatNobodySawIsSeen) {
  Press(0.02, {std::nullopt});
  Watch(2, {std::nullopt});
  EXPECT_NEAR(Out(), 0, 1e-4);
  Watch(0.03, heavy_);
  EXPECT_GT(Out(), 1.9e-3);
}

// It is not the tool that moved then.
TEST_F(RetreatTest, AToolAtRestForLongIsLeftWhereItIs) {
  LetGo();
  Watch(0.5, light_);
  Watch(0.5, heavy_);
  EXPECT_NEAR(Out(), 0, 1e-9);
}

TEST_F(RetreatTest, TheEmergencyStopEndsIt) {
  arm_.moves = false;
  Press(0.002, heavy_);
  guarded_->EmergencyStop();
  arm_.moves = true;
  Watch(0.1, heavy_);
  guarded_->Reset(guarded_->stops());
  Watch(0.1, heavy_);
  EXPECT_NEAR(Out(), 0, 1e-4);
}

// A hand trembles: 0.3 mm between its ends are less than 20 mm/s bring in 20 ms.
TEST_F(GuardedPortTest, ATremblingHandDrawsTheToolOutOfAGuard) {
  Use({.max_speed = 0.020, .force_guard = 2});
  const ContactState heavy{Vector3d(0, 2.1, 0), 1e-3, {0, 1, 0}};
  Press(0.004, heavy);
  const double held = arm_.Tip().y();
  epoch_ = 2;
  Send(Next({0, 0, 0}, true, 2));
  for (int k = 0; k < 100; ++k) {
    Send(Next({0, 1e-5 * k + (k % 2 == 0 ? 1.5e-4 : -1.5e-4), 0}, true, 2));
    EXPECT_GE(arm_.Tip().y(), held) << k;
    guarded_->Watch(now_ += Seconds(0.002), heavy);
  }
  EXPECT_EQ(phase(), Phase::kFollowing);
  EXPECT_GT(arm_.Tip().y(), held + 0.9e-3);
  Send(Next({0, -2e-3, 0}, true, 2));
  EXPECT_EQ(phase(), Phase::kHold) << "who presses on engages anew";
}

// Who hovers where it was reached would end an epoch at each tremble.
TEST_F(GuardedPortTest, AGuardFallsABitBelowWhereItIsReached) {
  Use({.max_speed = 0.020, .force_guard = 2});
  const auto feel = [this](double force) {
    Press(0.004, {Vector3d(0, force, 0), 1e-3, {0, 1, 0}});
    return phase();
  };
  EXPECT_EQ(feel(2.01), Phase::kHold);
  epoch_ = 2;
  y_ = 0;
  for (const double force : {1.99, 2.01, 1.95, 2.05}) EXPECT_EQ(feel(force), Phase::kFollowing);
  EXPECT_EQ(feel(1.85), Phase::kFollowing);
  EXPECT_EQ(feel(2.01), Phase::kHold);
}

// A sample is late, the arm's word is not.
TEST_F(GuardedPortTest, WhatTheToolFeelsByNowCountsToo) {
  Use({.max_speed = 0.020, .force_guard = 2, .depth_guard = 2e-3});
  ContactState contact{Vector3d(0, 0.5, 0), 1e-3, {0, 1, 0}};
  contact.force_by_now = 1.9;
  contact.depth_by_now = 1.9e-3;
  Press(0.01, contact);
  EXPECT_EQ(phase(), Phase::kFollowing);
  contact.force_by_now = 2.1;
  Press(0.002, contact);
  EXPECT_EQ(phase(), Phase::kHold);
  epoch_ = 2;
  contact.force_by_now = 0;
  Press(0.01, contact);
  EXPECT_EQ(phase(), Phase::kFollowing);
  contact.depth_by_now = 2.1e-3;
  Press(0.002, contact);
  EXPECT_EQ(phase(), Phase::kHold);
}

// Between two checks the arm goes wherever the last command led. By the local model that is never
// far beyond a guard: 2 mm, or 2 N at 1 N/mm.
TEST_F(GuardedPortTest, ALateCheckLetsTheToolGoLittleBeyondAGuard) {
  struct Case {
    ManipulatorOptions limits;
    double depth, force, way;  // [m], [N], [m]
  };
  const ManipulatorOptions by_depth{.max_speed = 0.020, .depth_guard = 2e-3};
  const ManipulatorOptions by_force{.max_speed = 0.020, .force_guard = 2};
  for (const Case& a : {Case{by_depth, 1e-3, 1, kFloor * 2e-3 - 1e-3},
                        Case{by_depth, -1e-3, 0, kFloor * 2e-3 + 1e-3},
                        Case{by_force, 1e-3, 1, kFloor * 2e-3 - 1e-3},
                        Case{by_force, -1e-3, 0, kFloor * 2e-3 + 1e-3}}) {
    sequence_ = 0;
    Use(a.limits);
    const Vector3d tip = arm_.Tip();
    guarded_->Watch(now_, {.force = Vector3d(0, a.force, 0),
                           .outward = Vector3d::UnitY(),
                           .depth_by_now = a.depth,
                           .normal = Vector3d::UnitY(),
                           .stiffness = 1000});
    for (const double down : {3.2e-3, 3.9e-3}) {
      EXPECT_TRUE(Send(Next({5e-4, -down, 0})));
      EXPECT_LT((arm_.Tip() - tip - Vector3d(5e-4, -a.way, 0)).norm(), 1e-12);
    }
    EXPECT_EQ(phase(), Phase::kFollowing);
    EXPECT_TRUE(Send(Next({0, 0, 0})));
    EXPECT_NEAR(arm_.Tip().y(), tip.y(), 1e-12) << "out is free";
  }
}

// An operator presses on at 20 mm/s and engages again before every motion. Samples are 50 ms old
// and 4 % off to either side, the local model is right. Reference: the spring, 1 N/mm, from y = 0.
TEST_F(GuardedPortTest, EngagementsDoNotAddUpBeyondAGuard) {
  constexpr double kSpring = 1000;
  for (const bool retracts : {false, true}) {
    sequence_ = 0;
    arm_.Place({0, 2e-3, 0});
    Use({.max_speed = 0.020, .force_guard = 2, .depth_guard = 3e-3, .guard_retracts = retracts});
    std::vector<double> depths;
    double deepest = 0, hand = 0;
    for (int step = 0; step < 2500; ++step) {
      const auto epoch = static_cast<std::uint32_t>(step) + 2;
      Send(Next({0, hand, 0}, true, epoch));
      hand -= 4e-5;
      Send(Next({0, hand, 0}, true, epoch));
      const double depth = -arm_.Tip().y();
      depths.push_back(std::max(0.0, depth));
      deepest = std::max(deepest, depth);
      const double old = depths[static_cast<std::size_t>(std::max(0, step - 25))];
      const double estimated = kSpring * old * (step % 10 < 5 ? 1.04 : 0.96);
      guarded_->Watch(now_ += Seconds(0.002), {.force = Vector3d(0, estimated, 0),
                                               .depth = old,
                                               .outward = Vector3d::UnitY(),
                                               .force_by_now = kSpring * depths.back(),
                                               .depth_by_now = depth,
                                               .normal = Vector3d::UnitY(),
                                               .stiffness = kSpring});
    }
    EXPECT_GT(kSpring * deepest, 1.9);
    EXPECT_LT(kSpring * deepest, kFloor * 2 + 1e-9);
  }
}

// The way down is dead, the way up is not: commands come that tell of no newer state.
TEST_F(GuardedPortTest, AnOperatorWhoFeelsNothingIsHeld) {
  const auto tell = [this](std::uint64_t state) {
    OperatorCommand command = Next({0, 0, 0}, true, epoch_);
    command.state_sequence = state;
    Send(command);
    now_ += Seconds(0.010);
    guarded_->Watch(now_, {Vector3d::Zero()});
  };
  for (std::uint64_t state = 1; state < 50; ++state) tell(state);
  EXPECT_EQ(phase(), Phase::kFollowing);
  for (int i = 0; i < 12; ++i) tell(49);
  EXPECT_EQ(phase(), Phase::kHold);
  EXPECT_TRUE(guarded_->TakeEvents().Has(Event::kHold));
  tell(60);
  tell(61);
  EXPECT_EQ(phase(), Phase::kFollowing) << "a short while ends by itself";
  for (int i = 0; i < 40; ++i) tell(61);
  tell(90);
  tell(91);
  EXPECT_EQ(phase(), Phase::kHold) << "a long one needs an act";
}

// Images define S: with encoders that are off by a constant, targets still mean what images
// see.
TEST_F(OperatorPortTest, TargetsAreGivenInTheFrameOfTheImages) {
  const Vector3d off(0.001, -0.002, 0);
  port_.SetRegistration(off);
  const Vector3d start = arm_.Tip();
  Send(Next({0, 0, 0}));
  EXPECT_LT((arm_.Tip() - start).norm(), 1e-15);
  EXPECT_LT((port_.view().offset - (start + off)).norm(), 1e-15);
}

// `tests/fuzz` looks for sequences that nobody draws.
TEST(ArmSequence, NoOrderOfEventsLeadsTheArmAstray) {
  for (unsigned seed = 1; seed <= 400; ++seed) {
    const auto bytes = RandomBytes(seed, 400);
    EXPECT_NO_THROW(RunArm(Choices(bytes))) << "seed " << seed;
  }
}

}  // namespace
}  // namespace palpate
