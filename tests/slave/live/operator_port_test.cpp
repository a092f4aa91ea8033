#include "slave/live/operator_port.h"

#include <functional>
#include <utility>

#include <gtest/gtest.h>

#include "tests/slave/live/arm_sequence.h"
#include "tests/slave/live/operator_port_fixture.h"
#include "tests/support/dice.h"
#include "tests/support/not_finite.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

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

// Law: releasing and engaging neither move nor rotate the slave, whatever the device does while the
// clutch is open or in another epoch.
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
    if (clutches) {  // the device moves anywhere, with or without commands
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

TEST_F(OperatorPortTest, AHeldTipHasAHeldRotation) {
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

// After each of them a valid command of the same epoch continues from the held position.
TEST_F(OperatorPortTest, CommandsThatCannotBeAreRefusedAndHoldTheTool) {
  const std::pair<const char*, std::function<void(OperatorCommand*)>> commands[] = {
      {"a position that is no number", [](OperatorCommand* c) { c->p_M.x() = kNan; }},
      {"an infinite position", [](OperatorCommand* c) { c->p_M.y() = kInf; }},
      {"a position far away", [](OperatorCommand* c) { c->p_M.y() = 1e300; }},
      {"a position beyond 100 m", [](OperatorCommand* c) { c->p_M.z() = -101; }},
      {"a velocity", [](OperatorCommand* c) { c->velocity.y() = 1e9; }},
      {"a rotation", [](OperatorCommand* c) { c->R_M_device = Eigen::Quaterniond(1, 0, kNan, 0); }},
      {"no epoch", [](OperatorCommand* c) { c->epoch = 0; }},
      {"an older epoch", [](OperatorCommand* c) { c->epoch = 4; }},
  };
  Send(Next({0, 0, 0}, true, 5));
  const Vector3d tip = arm_.Tip();
  std::uint64_t refused = 0;
  for (const auto& [name, apply] : commands) {
    OperatorCommand command = Next({0, 0, 0}, true, 5);
    apply(&command);
    EXPECT_FALSE(Send(command)) << name;
    EXPECT_EQ(port_.view().phase, Phase::kHold) << name;
    EXPECT_EQ(port_.counts().refused, ++refused) << name;
    EXPECT_TRUE(port_.TakeEvents().Has(Event::kCommandRefused)) << name;
    Send(Next({0, 0, 0}, true, 5));
    EXPECT_EQ(port_.view().phase, Phase::kFollowing) << name;
    EXPECT_EQ(arm_.Tip(), tip) << name;
  }
}

// According to the .proto an epoch begins with an engagement, so there may be none before the
// first.
TEST_F(OperatorPortTest, AnOpenClutchNeedsNoEpochAndHoldsInAny) {
  EXPECT_TRUE(Send(Next({0, 0, 0}, false, 0)));
  EXPECT_EQ(port_.view().phase, Phase::kClutched);
  EXPECT_FALSE(port_.TakeEvents().Has(Event::kCommandRefused));
  Send(Next({0, 0, 0}, true, 3));
  EXPECT_TRUE(Send(Next({0, 0.1, 0}, false, 2)));
  EXPECT_EQ(port_.view().phase, Phase::kClutched) << "whoever lets go is believed";
  EXPECT_EQ(port_.view().epoch, 3U);
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

// A client that opens an epoch before each step does not move the arm either, nor does one that
// reconnects.
TEST_F(GuardedPortTest, AnUnknownForceHoldsTheToolWhateverTheEpochOrLease) {
  Press(0.240, {std::nullopt});
  EXPECT_EQ(phase(), Phase::kFollowing);
  Press(0.030, {std::nullopt});
  EXPECT_EQ(phase(), Phase::kHold);
  EXPECT_TRUE(guarded_->TakeEvents().Has(Event::kHold));
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
  EXPECT_EQ(phase(), Phase::kHold) << "engaging again makes nothing known";
  guarded_->EndOperating();
  guarded_->BeginOperating();
  creep();
  EXPECT_EQ(arm_.Tip(), tip);
  guarded_->Watch(now_, {Vector3d::Zero()});
  EXPECT_TRUE(Send(Next({0, 0, 0}, true, ++epoch_)));
  EXPECT_EQ(phase(), Phase::kFollowing) << "a known force lets the tool follow again";
}

// The link from the slave to the master has failed, the other direction works: commands arrive that
// acknowledge no newer state.
TEST_F(GuardedPortTest, AnOperatorWithoutNewStatesIsHeld) {
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

// Images define S: with a constant offset of the encoders, targets are still positions in the
// images.
TEST_F(OperatorPortTest, TargetsAreGivenInTheFrameOfTheImages) {
  const Vector3d off(0.001, -0.002, 0);
  port_.SetRegistration(off);
  const Vector3d start = arm_.Tip();
  Send(Next({0, 0, 0}));
  EXPECT_LT((arm_.Tip() - start).norm(), 1e-15);
  EXPECT_LT((port_.view().offset - (start + off)).norm(), 1e-15);
}

// `tests/fuzz` searches for further sequences.
TEST(ArmSequence, NoOrderOfEventsMovesTheArmWrongly) {
  for (unsigned seed = 1; seed <= 400; ++seed) {
    const auto bytes = RandomBytes(seed, 400);
    EXPECT_NO_THROW(RunArm(Choices(bytes))) << "seed " << seed;
  }
}

}  // namespace
}  // namespace palpate
