#include "master/haptics/operator_machine.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

using enum OperatorState;

class OperatorMachineTest : public testing::Test {
 protected:
  // Runs `ms` ticks with the present inputs. Returns the last state.
  OperatorState Run(int ms = 1) {
    for (int i = 0; i < ms; ++i) {
      in_.now += 0.001;
      machine_.Step(in_);
    }
    return machine_.state();
  }
  void Follow() {
    in_.state_age = 0.001;
    in_.force_known = true;
    in_.engaged = false;
    Run(2);
    in_.engaged = true;
    Run();
    in_.slave_epoch = machine_.epoch();
    in_.slave_phase = Phase::kFollowing;
    ASSERT_EQ(Run(), kFollowing);
  }

  OperatorMachine machine_;
  OperatorMachine::Input in_;
};

TEST_F(OperatorMachineTest, ASwitchThatWasNeverOpenDoesNotEngage) {
  in_.state_age = 0.001;
  in_.force_known = true;
  in_.engaged = true;
  EXPECT_EQ(Run(1000), kReady);
  EXPECT_EQ(machine_.epoch(), 0U);
}

TEST_F(OperatorMachineTest, TheClutchOpensAtOnceAndEachClosingIsANewEpoch) {
  Follow();
  in_.engaged = false;
  EXPECT_EQ(Run(), kClutched);
  EXPECT_FALSE(machine_.commands_engaged());
  in_.engaged = true;
  EXPECT_EQ(Run(), kAligning);
  EXPECT_EQ(machine_.epoch(), 2U);
  EXPECT_EQ(Run(10), kAligning) << "the slave is still in the old epoch";
  in_.slave_epoch = 2;
  EXPECT_EQ(Run(), kFollowing);
}

TEST_F(OperatorMachineTest, SilenceBeyondThirtyMillisecondsHolds) {
  Follow();
  in_.state_age = 0.030;
  EXPECT_EQ(Run(), kFollowing);
  in_.state_age = 0.031;
  EXPECT_EQ(Run(), kHold);
}

// The link to the slave can fail alone: states arrive, but the tool does not move.
TEST_F(OperatorMachineTest, AToolThatDoesNotFollowHoldsAndLastingSoNeedsANewEngagement) {
  Follow();
  in_.slave_phase = Phase::kHold;
  EXPECT_EQ(Run(), kHold);
  EXPECT_EQ(Run(200), kHold);
  in_.slave_phase = Phase::kFollowing;
  EXPECT_EQ(Run(), kFollowing);
  in_.slave_phase = Phase::kHold;
  EXPECT_EQ(Run(252), kReady);
  EXPECT_FALSE(machine_.commands_engaged());
  EXPECT_EQ(Run(100), kReady) << "the switch has not been open since";
}

TEST_F(OperatorMachineTest, ResumesWithin250MillisecondsAndNotLater) {
  Follow();
  in_.state_age = 0.1;
  Run(240);
  in_.state_age = 0.001;
  EXPECT_EQ(Run(), kFollowing);
  in_.state_age = 0.1;
  Run(260);
  EXPECT_EQ(machine_.state(), kHold);
  in_.state_age = 0.001;
  EXPECT_EQ(Run(), kReady);
  EXPECT_EQ(Run(1000), kReady) << "the operator never let go";
  in_.engaged = false;
  Run();
  in_.engaged = true;
  EXPECT_EQ(Run(), kAligning);
}

TEST_F(OperatorMachineTest, ALongSilenceDisconnects) {
  Follow();
  in_.state_age = 1.5;
  EXPECT_EQ(Run(300), kDisconnected);
  in_.state_age = 0.001;
  EXPECT_EQ(Run(100), kReady);
}

TEST_F(OperatorMachineTest, ASlaveThatNeverAlignsIsGivenUp) {
  in_.state_age = 0.001;
  in_.force_known = true;
  Run(2);
  in_.engaged = true;
  EXPECT_EQ(Run(900), kAligning);
  EXPECT_EQ(Run(1200), kReady);
  EXPECT_EQ(machine_.epoch(), 1U);
}

TEST_F(OperatorMachineTest, EmergencyStopIsLatchedUntilResetAndANewAct) {
  Follow();
  in_.slave_phase = Phase::kEstop;
  EXPECT_EQ(Run(), kEstop);
  in_.state_age = 5;
  EXPECT_EQ(Run(1000), kDisconnected) << "not known without a state";
  in_.state_age = 0.001;
  in_.slave_phase = Phase::kReady;
  EXPECT_EQ(Run(100), kReady) << "still pressed since before the stop";
  in_.engaged = false;
  Run();
  in_.engaged = true;
  EXPECT_EQ(Run(), kAligning);
}

TEST_F(OperatorMachineTest, ARequestedStopIsNoStopUntilAStateSaysSo) {
  Follow();
  in_.stop = true;
  EXPECT_EQ(Run(), kStopRequested);
  in_.state_age = 5;
  EXPECT_EQ(Run(1000), kStopRequested) << "the link is cut";
  in_.state_age = 0.001;
  in_.stop = false;
  in_.slave_phase = Phase::kEstop;
  EXPECT_EQ(Run(), kEstop);
}

TEST_F(OperatorMachineTest, AnObserverShowsTheStopOfTheSlaveAndItsEnd) {
  in_.observed = true;
  in_.state_age = 0.02;
  in_.force_known = true;
  EXPECT_EQ(Run(), kDisconnected);
  in_.slave_phase = Phase::kEstop;
  EXPECT_EQ(Run(), kEstop);
  in_.slave_phase = Phase::kFollowing;
  EXPECT_EQ(Run(), kDisconnected) << "another operator works on";
  in_.engaged = true;
  EXPECT_EQ(Run(100), kDisconnected);
}

}  // namespace
}  // namespace palpate
