#include "master/haptics/haptic_loop.h"

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/master/haptics/rig.h"

namespace palpate {
namespace {

using enum OperatorState;
constexpr double kInside = -0.006;  // y, 2 mm below the virtual slave's surface [m]

// Master and slave with the tool following, 2 mm deep in a wall of 500 N/m: 1 N.
class HapticLoopTest : public testing::Test {
 protected:
  void SetUp() override { Engage(rig_); }
  void Engage(Rig& rig) {
    puppet_.reading = {};
    rig.Run(puppet_, 0.05);
    rig.Engage(puppet_, 0.05);
    ASSERT_EQ(rig.state(), kFollowing);
    rig.Glide(puppet_, {0, kInside, 0});
    rig.Run(puppet_, 0.1);
  }

  Rig rig_;
  Puppet puppet_;
};

TEST_F(HapticLoopTest, MapsPositionsAndForcesBetweenTheFrames) {
  VirtualSlave::Options options;
  options.home = {0.1, 0.2, 0};
  options.surface = 0.199;
  options.transform.position_scale = 0.5;
  options.transform.force_scale = 3;
  options.transform.R_SM << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // x of M is y of S
  Rig rig(options);
  puppet_.reading = {};
  rig.Run(puppet_, 0.05);
  rig.Engage(puppet_, 0.05);
  ASSERT_EQ(rig.state(), kFollowing);
  EXPECT_TRUE(puppet_.guide.known);
  EXPECT_NEAR(puppet_.guide.gap_M, 0.002, 1e-9);
  EXPECT_NEAR((puppet_.guide.inward_M - Eigen::Vector3d(-1, 0, 0)).norm(), 0, 1e-12);
  rig.Glide(puppet_, {-0.004, 0, 0});  // 2 mm along -y of S, of which 1 mm inside: 0.5 N
  rig.Run(puppet_, 0.1);
  EXPECT_NEAR((puppet_.force - Eigen::Vector3d(1.5, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR((rig.loop.record().p_S - Eigen::Vector3d(0.1, 0.198, 0)).norm(), 0, 1e-9);
}

// The clutch closes again with the tool 2 mm inside, and the device retreats at 20 mm/s. The
// contact returns only energy that was put in before, so nothing is damped and the force follows
// the law throughout.
TEST_F(HapticLoopTest, AContactThatBeginsPressedReturnsItsEnergy) {
  rig_.Release(puppet_, 0.2);
  rig_.Engage(puppet_, 0.1);
  ASSERT_EQ(rig_.state(), kFollowing);
  EXPECT_NEAR(puppet_.force.y(), 1.0, 1e-12);
  puppet_.reading.v_M.y() = 0.020;
  rig_.Run(puppet_, 0.095, [&](const TickRecord& record) {
    puppet_.reading.p_M.y() += 0.020e-3;
    EXPECT_FALSE(record.chain.reasons.Has(Reason::kPassivity)) << record.p_S.transpose();
  });
  EXPECT_NEAR(puppet_.force.y(), 0.05, 0.011);
}

TEST_F(HapticLoopTest, SilenceHoldsTenMillisecondsThenFadesToZeroInForty) {
  rig_.slave.silent = true;
  std::vector<double> forces;
  double lost_at = 0;
  for (int i = 0; i < 150; ++i) {
    const TickRecord& record = rig_.Tick(puppet_);
    if (record.state == kHold && lost_at == 0) lost_at = i;
    forces.push_back(puppet_.force.y());
    if (i > 0) {
      EXPECT_LE(std::abs(forces[forces.size() - 1] - forces[forces.size() - 2]), 0.0251)
          << "a kick at " << i;
    }
  }
  EXPECT_NEAR(lost_at, 30, 3);
  const auto at = [&](double ms) { return forces[static_cast<std::size_t>(lost_at + ms)]; };
  EXPECT_NEAR(at(8), 1, 1e-12);
  EXPECT_NEAR(at(30), 0.5, 0.06);
  EXPECT_EQ(at(52), 0) << "80 ms after the last state, and the two ticks of measuring it";
}

// A device removes its force at a fault. A loop that faded from its own last force would apply it
// again.
TEST_F(HapticLoopTest, AfterADeviceFaultTheForceIsZeroUntilANewEngagement) {
  ASSERT_NEAR(puppet_.force.y(), 1, 1e-12);
  puppet_.reading.status.fault = DeviceFault::kSilent;
  puppet_.reading.engaged = false;
  const auto is_zero = [&](const TickRecord&) { ASSERT_EQ(puppet_.force.norm(), 0); };
  rig_.Run(puppet_, 0.003, is_zero);
  puppet_.reading.status.fault = DeviceFault::kNone;
  rig_.Run(puppet_, 0.2, is_zero);
  rig_.Engage(puppet_, 0.1);
  EXPECT_NEAR(puppet_.force.y(), 1, 0.05);
}

TEST_F(HapticLoopTest, FreshStatesWithin250MillisecondsBlendBackIn) {
  rig_.slave.silent = true;
  rig_.Run(puppet_, 0.150);
  EXPECT_EQ(puppet_.force.norm(), 0);
  rig_.slave.silent = false;
  double last = 0;
  for (int i = 0; i < 60; ++i) {
    rig_.Tick(puppet_);
    EXPECT_LE(puppet_.force.y() - last, 0.0201);
    last = puppet_.force.y();
  }
  EXPECT_EQ(rig_.state(), kFollowing);
  EXPECT_NEAR(last, 1, 1e-12);
}

// While the force is unknown, the tool must not be pushed deeper.
TEST_F(HapticLoopTest, LostTrackingFadesTheForceAndStopsTheTool) {
  rig_.slave.validity = Validity::kTrackingLost;
  rig_.Run(puppet_, 0.01);
  EXPECT_EQ(rig_.state(), kHold);
  const double before = rig_.slave.tip().y();
  puppet_.reading.p_M.y() -= 0.003;
  rig_.Run(puppet_, 0.1);
  EXPECT_EQ(puppet_.force.norm(), 0);
  EXPECT_EQ(rig_.slave.tip().y(), before);
  EXPECT_TRUE(rig_.loop.record().chain.reasons.Has(Reason::kUnknown));
}

TEST_F(HapticLoopTest, APunctureDropsTheForceFastButNotInAStep) {
  rig_.slave.validity = Validity::kPunctured;
  double last = puppet_.force.y();
  rig_.Run(puppet_, 0.014, [&](const TickRecord&) {
    EXPECT_LE(std::abs(puppet_.force.y() - last), 0.101);
    last = puppet_.force.y();
  });
  EXPECT_EQ(last, 0);
  EXPECT_EQ(rig_.state(), kFollowing);
}

TEST_F(HapticLoopTest, ARestartedSlaveIsNotFollowedOn) {
  rig_.slave.forgets = true;
  rig_.Run(puppet_, 0.010);
  EXPECT_EQ(rig_.state(), kHold);
  rig_.Run(puppet_, 0.4);
  EXPECT_EQ(rig_.state(), kReady);
}

TEST_F(HapticLoopTest, TheForceNeverExceedsTheLimit) {
  puppet_.reading.p_M.y() = -0.5;
  rig_.Run(puppet_, 0.1, [&](const TickRecord& record) {
    EXPECT_LE(puppet_.force.norm(), 3.3 * (1 + 1e-12));
    EXPECT_TRUE(record.chain.reasons.Has(Reason::kClamped));
    EXPECT_TRUE(record.chain.reasons.Has(Reason::kBeyondModel));
  });
}

TEST_F(HapticLoopTest, ImpossibleDeviceReadingsNeverReachHandOrSlave) {
  for (const double bad : {std::nan(""), 1e300, -std::numeric_limits<double>::infinity()}) {
    puppet_.reading.p_M.x() = bad;
    rig_.Run(puppet_, 0.1, [&](const TickRecord& record) {
      EXPECT_TRUE(puppet_.force.allFinite());
      EXPECT_LE(puppet_.force.norm(), 3.3);
      EXPECT_TRUE(record.p_M.allFinite() && record.p_S.allFinite());
      EXPECT_TRUE(record.chain.reasons.Has(Reason::kBadDevice));
      EXPECT_TRUE(rig_.slave.tip().allFinite());
    });
    EXPECT_EQ(puppet_.force.norm(), 0);
    puppet_.reading.p_M.x() = 0;
    puppet_.reading.v_M.z() = bad;
    rig_.Run(puppet_, 0.01, [&](const TickRecord&) { EXPECT_TRUE(puppet_.force.allFinite()); });
    puppet_.reading.v_M.z() = 0;
  }
}

// Each number of a state in turn gets an impossible value: the force stays finite and within the
// limit, and a slave that sends only such states is treated as silent.
TEST_F(HapticLoopTest, ImpossibleStatesAreIgnoredAndThenHold) {
  const std::vector<std::function<void(SlaveState*, double)>> faults{
      [](SlaveState* s, double bad) { s->force = Eigen::Vector3d(0, bad, 0); },
      [](SlaveState* s, double bad) { s->p_S_tip.x() = bad; },
      [](SlaveState* s, double bad) { s->offset.z() = bad; },
      [](SlaveState* s, double bad) { s->true_force = Eigen::Vector3d(bad, 0, 0); },
      [](SlaveState* s, double bad) { s->local_model.stiffness(1, 1) = bad; },
      [](SlaveState* s, double bad) { s->local_model.reference.y() = bad; },
      [](SlaveState* s, double bad) {
        s->local_model.normal = {bad, bad, bad};
      },
      [](SlaveState* s, double bad) { s->local_model.force.y() = bad; },
      [](SlaveState* s, double) { s->finger_count = 6; },
      [](SlaveState* s, double) { s->finger_count = -1; },
      [](SlaveState* s, double bad) {
        s->finger_count = 2;
        s->fingers[1].p_S_contact.x() = static_cast<float>(bad);
      },
      [](SlaveState* s, double bad) {
        s->finger_count = 2;
        s->fingers[1].force = Eigen::Vector3f(0, 0, static_cast<float>(bad));
      },
  };
  for (std::size_t i = 0; i < faults.size(); ++i) {
    for (const double bad : {std::nan(""), 1e300, std::numeric_limits<double>::infinity()}) {
      Rig rig;
      Engage(rig);
      for (int tick = 0; tick < 100; ++tick) {
        rig.slave.silent = true;
        SlaveState state;
        state.validity = Validity::kValid;
        state.force = Eigen::Vector3d(0, 1, 0);
        state.epoch = 1;
        state.phase = Phase::kFollowing;
        state.local_model.revision = 5;
        faults[i](&state, bad);
        rig.states.Put({state, rig.now, 0});
        rig.Tick(puppet_);
        ASSERT_TRUE(puppet_.force.allFinite()) << i;
        ASSERT_LE(puppet_.force.norm(), 3.3) << i;
        ASSERT_TRUE(rig.loop.record().chain.reasons.Has(Reason::kBadState)) << i;
      }
      EXPECT_EQ(rig.state(), kHold) << i;
      EXPECT_EQ(puppet_.force.norm(), 0) << i;
    }
  }
}

TEST_F(HapticLoopTest, CommandsAreAbsoluteNumberedAndCarryEpochAndEcho) {
  rig_.Tick(puppet_);
  const OperatorCommand* command = rig_.commands.Take();
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->epoch, 1U);
  EXPECT_TRUE(command->engaged);
  EXPECT_EQ(command->p_M.y(), kInside);
  EXPECT_GT(command->state_sequence, 0U);
  EXPECT_TRUE(command->echo.has_value());
  const std::uint64_t sequence = command->sequence;
  rig_.loop.Release(rig_.now);
  command = rig_.commands.Take();
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->sequence, sequence + 1);
  EXPECT_FALSE(command->engaged);
}

// After the end of the stream the loop does not wait for the timeout: 40 ms from the end, not 80.
TEST_F(HapticLoopTest, TheEndOfTheStreamFadesAtOnce) {
  rig_.slave.silent = true;
  rig_.states.Put({SlaveState(), rig_.now, 0, 0, true});
  double last = puppet_.force.y();
  for (int i = 0; i < 42; ++i) {
    const TickRecord& record = rig_.Tick(puppet_);
    EXPECT_TRUE(record.chain.reasons.Has(Reason::kEnded));
    EXPECT_LE(puppet_.force.y(), last);
    last = puppet_.force.y();
  }
  EXPECT_EQ(last, 0);
  EXPECT_EQ(rig_.state(), kHold);
}

// 60 ms (with an arm, 40 ms) have passed in the slave by then; with the link's delay the total is
// at most 100 ms.
TEST_F(HapticLoopTest, ASilentSensorOrArmLeavesNoForceAfterThirtyMilliseconds) {
  const auto is_stale = [](SlaveState* state) { state->validity = Validity::kStale; };
  const auto is_faulty = [](SlaveState* state) {
    state->phase = Phase::kHold;
    state->check = FailedCheck::kArmFault;
  };
  for (const std::function<void(SlaveState*)>& falsify :
       {std::function<void(SlaveState*)>(is_stale), std::function<void(SlaveState*)>(is_faulty)}) {
    Rig rig;
    Engage(rig);
    ASSERT_GT(puppet_.force.y(), 0.5);
    rig.slave.falsify = falsify;
    double last = puppet_.force.y();
    rig.Run(puppet_, 0.034, [&](const TickRecord&) {
      EXPECT_LE(puppet_.force.y(), last);
      EXPECT_LT(last - puppet_.force.y(), 0.05);
      last = puppet_.force.y();
    });
    EXPECT_EQ(rig.state(), kHold);
    EXPECT_EQ(last, 0);
  }
}

// With timestamps from 1970, constant ones or ones from the future the force is held and then
// fades, with a reason.
TEST_F(HapticLoopTest, SamplesThatAreTooOldOrInTheFutureAreNotRendered) {
  for (const double seconds : {-1e9, -0.3, 86400.0}) {
    Rig rig;
    Engage(rig);
    const Time then = rig.now + Seconds(1000 + seconds);  // the slave's clock is 1000 s ahead
    rig.slave.falsify = [then](SlaveState* state) { state->sensed_at = then; };
    rig.Run(puppet_, 0.1);
    EXPECT_EQ(rig.state(), kHold) << seconds;
    EXPECT_EQ(puppet_.force.norm(), 0) << seconds;
    EXPECT_TRUE(rig.loop.record().chain.reasons.Has(Reason::kAged)) << seconds;
    rig.Run(puppet_, 0.5);
    rig.Release(puppet_, 0.05);
    rig.Engage(puppet_, 0.05);
    EXPECT_NE(rig.state(), kFollowing) << seconds;
  }
}

TEST_F(HapticLoopTest, AnOffsetThatMovesWithinAnEpochIsNotFollowed) {
  rig_.slave.falsify = [](SlaveState* state) { state->offset.y() -= 0.05; };
  rig_.Run(puppet_, 0.06);
  EXPECT_EQ(rig_.state(), kHold);
  EXPECT_EQ(puppet_.force.norm(), 0);
  EXPECT_TRUE(rig_.loop.record().chain.reasons.Has(Reason::kOffsetJump));
}

// A slave that was restarted during an emergency stop reports the used epoch with a different
// offset. After the reset the operator can engage as usual.
TEST_F(HapticLoopTest, AfterAStopASlaveThatWasRestartedIsFollowed) {
  bool stops = true;
  rig_.slave.falsify = [&stops](SlaveState* state) {
    state->offset.y() -= 0.05;
    if (stops) state->phase = Phase::kEstop;
  };
  rig_.Run(puppet_, 0.06);
  ASSERT_EQ(rig_.state(), OperatorState::kEstop);
  puppet_.reading.engaged = false;
  stops = false;
  rig_.Run(puppet_, 0.06);
  rig_.Engage(puppet_, 0.3);
  EXPECT_EQ(rig_.state(), kFollowing);
}

// The loop does not work with settings that it has not read: no force is rendered and the tool is
// held until they are read and the operator engages again.
TEST_F(HapticLoopTest, ChangedSettingsRenderNoForceUntilReadAndEngagedAgain) {
  rig_.slave.falsify = [](SlaveState* state) { state->settings_revision = 7; };
  rig_.Run(puppet_, 0.06);
  EXPECT_EQ(rig_.state(), kHold);
  EXPECT_EQ(puppet_.force.norm(), 0);
  EXPECT_TRUE(rig_.loop.record().chain.reasons.Has(Reason::kSettings));
  TeleopTransform halved;
  halved.force_scale = 0.5;
  rig_.settings.Put({7, halved, 3.3});
  rig_.Run(puppet_, 0.5);
  EXPECT_EQ(rig_.state(), kReady);
  rig_.Release(puppet_, 0.01);
  rig_.Engage(puppet_, 0.1);
  EXPECT_EQ(rig_.state(), kFollowing);
  EXPECT_NEAR(puppet_.force.y(), 0.5, 1e-9);
  const OperatorCommand* command = rig_.commands.Take();
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->settings_revision, 7U);
}

// The sensor of a new scene may be faster than the sensor for which the loop was made.
TEST_F(HapticLoopTest, TheLargestAgeIsThatOfTheSettingsThatWereRead) {
  rig_.Run(puppet_, 0.1);
  EXPECT_FALSE(rig_.loop.record().chain.reasons.Has(Reason::kAged));
  rig_.settings.Put({.transform = {}, .force_limit = 3.3, .max_age = 1e-6});
  rig_.Run(puppet_, 0.1);
  EXPECT_TRUE(rig_.loop.record().chain.reasons.Has(Reason::kAged));
}

// The operator has just closed the switch, and the slave has not answered yet: commands carry the
// revision that they are made by, so that the slave does not follow, and the engagement ends.
TEST(HapticLoopAlignTest, NewSettingsEndAnEngagementThatBegins) {
  Rig rig({.delay = 0.1});
  Puppet puppet;
  rig.settings.Put({6, {}, 3.3});
  rig.slave.falsify = [](SlaveState* state) { state->settings_revision = 6; };
  rig.Run(puppet, 0.5);
  rig.Engage(puppet, 0.05);
  ASSERT_EQ(rig.state(), OperatorState::kAligning);
  TeleopTransform large;
  large.position_scale = 10;
  rig.settings.Put({7, large, 3.3});
  rig.Tick(puppet);
  EXPECT_EQ(rig.state(), OperatorState::kReady);
  const OperatorCommand* command = rig.commands.Take();
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->settings_revision, 6U);
  EXPECT_FALSE(command->engaged);
  rig.Tick(puppet);
  EXPECT_EQ(rig.commands.Take()->settings_revision, 7U);
  rig.Run(puppet, 1);
  EXPECT_EQ(rig.state(), OperatorState::kReady) << "until the switch was open";
}

// The slave's echoes come later and later, as if the network had become slow. States that are older
// than the sensor and the network can explain are not rendered.
TEST(HapticLoopAgeTest, DelayedEchoesDoNotMakeOldStatesAcceptable) {
  for (const double longest : {std::numeric_limits<double>::infinity(), 1.0}) {
    HapticLoop::Options options;
    options.max_trip = longest;
    VirtualSlave::Options slave;
    slave.delay = 0.01;
    Rig rig(options, slave);
    Puppet puppet;
    rig.Run(puppet, 0.2);
    rig.Engage(puppet, 0.2);
    ASSERT_EQ(rig.state(), OperatorState::kFollowing);
    const auto tell = [&](double round_trip, double seconds) {
      for (const Time end = rig.now + Seconds(seconds); rig.now < end;) {
        rig.now += kHapticPeriod;
        rig.slave.Step(rig.now, &rig.commands, &rig.states);
        if (const ReceivedState* received = rig.states.Take()) {
          ReceivedState altered = *received;
          altered.round_trip = round_trip;
          rig.states.Put(altered);
        }
        rig.loop.Tick(puppet.reading, rig.now);
      }
    };
    tell(5, 0.1);
    EXPECT_EQ(rig.state(), OperatorState::kFollowing) << "its states are young";
    rig.slave.falsify = [](SlaveState* state) { state->sensed_at -= Seconds(1.5); };
    tell(5, 0.1);
    EXPECT_NE(rig.state(), OperatorState::kFollowing);
    EXPECT_TRUE(rig.loop.record().chain.reasons.Has(Reason::kAged));
    if (longest > 1) continue;
    tell(5, 30);  // long enough to forget the shorter round trips
    EXPECT_TRUE(rig.loop.record().chain.reasons.Has(Reason::kAged));
  }
}

// The link was cut and returns while the slave kept running. The settings are read again. The
// slave's offset is still that of the epoch, which began with the device at another position than
// the tool.
TEST(HapticLoopReturnTest, AnEngagementGoesOnAfterACutOfTheLine) {
  VirtualSlave::Options options;
  options.home = {0, 0.010, 0};
  Rig rig(options);
  Puppet puppet;
  rig.Run(puppet, 0.1);
  rig.Engage(puppet, 0.2);
  ASSERT_EQ(rig.state(), OperatorState::kFollowing);
  rig.slave.silent = true;
  rig.Run(puppet, 0.2);
  EXPECT_NE(rig.state(), OperatorState::kFollowing);
  rig.settings.Put({0, options.transform, 3.3});
  rig.slave.silent = false;
  rig.Release(puppet, 0.1);
  EXPECT_FALSE(rig.loop.record().chain.reasons.Has(Reason::kOffsetJump));
  rig.Engage(puppet, 0.2);
  EXPECT_EQ(rig.state(), OperatorState::kFollowing);
}

// The request is repeated until the slave confirms it.
TEST_F(HapticLoopTest, TheOperatorsEmergencyStopIsReportedAndLetsTheHandGo) {
  rig_.loop.stops().Request();
  rig_.Tick(puppet_);
  EXPECT_EQ(rig_.state(), OperatorState::kStopRequested);
  const OperatorCommand* command = rig_.commands.Take();
  ASSERT_NE(command, nullptr);
  EXPECT_TRUE(command->stop);
  EXPECT_FALSE(command->engaged);
  rig_.Run(puppet_, 0.045);
  EXPECT_EQ(puppet_.force.norm(), 0);
  rig_.slave.forced_phase = Phase::kEstop;
  rig_.Run(puppet_, 0.01);
  EXPECT_FALSE(rig_.commands.Take()->stop);
  EXPECT_EQ(rig_.state(), kEstop);
}

// The last state before the link failed reports an older stop that has been reset since.
TEST_F(HapticLoopTest, AStopIsNotTakenForReportedByTheStateOfAnOlderOne) {
  rig_.slave.forced_phase = Phase::kEstop;
  rig_.Run(puppet_, 0.1);
  rig_.slave.silent = true;
  rig_.Run(puppet_, 0.1);
  rig_.loop.stops().Request();
  rig_.Run(puppet_, 0.1);
  EXPECT_TRUE(rig_.commands.Take()->stop);
}

// A round trip of 0.5 s: stopped, reset, and stopped again before the reset is seen.
TEST(EmergencyStopTest, EachIsReportedHoweverSoonAfterAReset) {
  Rig rig({.delay = 0.25});
  Puppet puppet;
  rig.Run(puppet, 1);
  rig.loop.stops().Request();
  rig.Run(puppet, 0.25);
  rig.slave.forced_phase = Phase::kEstop;
  rig.Run(puppet, 0.2);
  EXPECT_TRUE(rig.loop.stops().is_wanted());
  rig.Run(puppet, 0.1);
  EXPECT_FALSE(rig.loop.stops().is_wanted());
  rig.loop.stops().Request();
  rig.Run(puppet, 0.2);
  rig.slave.forced_phase = Phase::kReady;  // the reset, which was in transit
  rig.Run(puppet, 1);
  EXPECT_TRUE(rig.loop.stops().is_wanted());
  rig.slave.forced_phase = Phase::kEstop;
  rig.Run(puppet, 0.3);
  EXPECT_FALSE(rig.loop.stops().is_wanted());
}

// A station that does not operate stops by a call. It must not stop a second time when it operates
// later.
TEST_F(HapticLoopTest, AStopThatArrivedByACallIsNotSentAgain) {
  rig_.loop.stops().Request();
  rig_.Tick(puppet_);
  rig_.loop.stops().Act(1, 9);
  rig_.Tick(puppet_);
  EXPECT_FALSE(rig_.commands.Take()->stop);
  EXPECT_EQ(rig_.state(), OperatorState::kStopRequested) << "no state shows that stop";
  rig_.loop.stops().Request();
  rig_.loop.stops().Act(1, 9);
  rig_.Tick(puppet_);
  EXPECT_TRUE(rig_.commands.Take()->stop) << "another one";
}

TEST_F(HapticLoopTest, ClocksThatJumpDoNotHurt) {
  for (const auto jump :
       {std::chrono::hours(1), std::chrono::hours(-2), std::chrono::hours(30000)}) {
    rig_.now += jump;
    rig_.Run(puppet_, 0.02, [&](const TickRecord&) {
      ASSERT_TRUE(puppet_.force.allFinite());
      ASSERT_LE(puppet_.force.norm(), 3.3);
    });
  }
}

}  // namespace
}  // namespace palpate
