// An arm that a driver moves: which targets it gets and which of its reports are accepted. The test
// sets the time.
#include "slave/manipulator/streamed_manipulator.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using Motion = ArmAim::Motion;

Time test_time;
Time Now() {
  return test_time;
}

constexpr double kReportPeriod = 1e-3;  // [s]
constexpr double kClockOffset = 1e5;    // of the driver's clock [s]
constexpr DriverId kDriver = 1, kOther = 2;

class StreamedManipulatorTest : public testing::Test {
 protected:
  StreamedManipulatorTest() { test_time = Time{} + Seconds(1000); }

  ArmReading Reading(const Vector3d& p_S_tip) {
    ArmReading reading;
    reading.sequence = ++sequence_;
    reading.measured_at = test_time + Seconds(kClockOffset);
    reading.p_S_tip = p_S_tip;
    return reading;
  }
  std::optional<DriverRefusal> Report(const Vector3d& p_S_tip) {
    return arm_.Take(kDriver, "a driver", Reading(p_S_tip), test_time);
  }
  void Pass(double seconds) { test_time += Seconds(seconds); }
  // Simulates a perfect arm for `seconds`. Returns its last target.
  Vector3d Drive(double seconds) {
    for (double t = 0; t < seconds; t += kReportPeriod) {
      Pass(kReportPeriod);
      const ArmAim aim = arm_.Aim(test_time);
      if (aim.motion == Motion::kFollow) tip_ = aim.p_S_tip;
      fastest_ = std::max(fastest_, aim.velocity.norm());
      EXPECT_EQ(Report(tip_), std::nullopt);
    }
    return tip_;
  }

  ManipulatorOptions options_{.home = {0, 0, 0},
                              .max_speed = 0.05,
                              .workspace_min = {-0.1, -0.1, -0.1},
                              .workspace_max = {0.1, 0.1, 0.1}};
  StreamedManipulator arm_{options_, &Now};
  std::uint64_t sequence_ = 0;
  Vector3d tip_{0.01, 0, 0};
  double fastest_ = 0;
};

TEST_F(StreamedManipulatorTest, WithoutADriverItHasAFaultAndFollowsNobody) {
  EXPECT_TRUE(arm_.is_faulty());
  EXPECT_FALSE(arm_.Command({0.01, 0, 0}));
  EXPECT_EQ(arm_.Aim(test_time).motion, Motion::kHold);
  EXPECT_THAT(arm_.health()->fault, HasSubstr("no driver of the manipulator is connected"));
}

TEST_F(StreamedManipulatorTest, NoTargetIsFasterThanTheSceneAllows) {
  Drive(0.1);
  ASSERT_TRUE(arm_.Command({0.05, 0.02, 0}));
  EXPECT_TRUE((Drive(2) - Vector3d(0.05, 0.02, 0)).isZero(1e-9));
  EXPECT_LE(fastest_, options_.max_speed * (1 + 1e-9));
  EXPECT_GT(fastest_, 0.9 * options_.max_speed);
}

TEST_F(StreamedManipulatorTest, NoTargetLeavesTheWorkspace) {
  Drive(0.1);
  ASSERT_TRUE(arm_.Command({5, 0, 0}));
  EXPECT_EQ(Drive(4), Vector3d(0.1, 0, 0));
  EXPECT_TRUE(arm_.at_limit());
}

using Eigen::AngleAxisd;
using Eigen::Quaterniond;

// An arm with a wrist that follows its targets at once.
class TurningArmTest : public StreamedManipulatorTest {
 protected:
  TurningArmTest() { Turn(0.1); }

  // Follows the targets for `seconds`. Returns their largest angular speed [rad/s].
  double Turn(double seconds) {
    double fastest = 0;
    for (double t = 0; t < seconds; t += kReportPeriod) {
      Pass(kReportPeriod);
      const ArmAim aim = arm_.Aim(test_time);
      if (aim.motion == Motion::kFollow) {
        tip_ = aim.p_S_tip;
        fastest = std::max(fastest, rotation_.angularDistance(*aim.R_S_tool) / kReportPeriod);
        rotation_ = *aim.R_S_tool;
      }
      ArmReading reading = Reading(tip_);
      reading.R_S_tool = rotation_;
      if (++reports_ % 2 == 0) reading.R_S_tool->coeffs() *= -1;
      EXPECT_EQ(arm_.Take(kDriver, "a driver", reading, test_time), std::nullopt);
    }
    return fastest;
  }

  const Quaterniond start_{AngleAxisd(0.7, Vector3d(1, 2, 3).normalized())};
  Quaterniond rotation_ = start_;
  int reports_ = 0;
};

TEST_F(TurningArmTest, FollowsTheShorterWayAtNoMoreThanTheAngularSpeedOfTheScene) {
  ASSERT_TRUE(arm_.Command(tip_));
  const Quaterniond target = AngleAxisd(2, Vector3d::UnitZ()) * start_;
  arm_.Turn(Quaterniond(-target.coeffs()));
  const double fastest = Turn(0.5);
  EXPECT_LT(fastest, options_.max_angular_speed * (1 + 1e-6));
  EXPECT_GT(fastest, 0.9 * options_.max_angular_speed);
  EXPECT_TRUE(arm_.at_limit());
  EXPECT_NEAR(rotation_.angularDistance(start_), 0.5 * options_.max_angular_speed, 0.01);
  Turn(2);
  EXPECT_LT(rotation_.angularDistance(target), 1e-7);
  EXPECT_FALSE(arm_.at_limit());
}

TEST_F(TurningArmTest, ItsTargetsNeverChangeSign) {
  ASSERT_TRUE(arm_.Command(tip_));
  Quaterniond last = *arm_.Aim(test_time).R_S_tool;
  for (int i = 0; i < 40; ++i) {
    arm_.Turn(Quaterniond((i % 2 == 0 ? 1 : -1) *
                          (AngleAxisd(0.3 * i, Vector3d::UnitX()) * start_).coeffs()));
    Turn(0.3);
    if (i % 5 == 4) arm_.Hold();
    const Quaterniond now = *arm_.Aim(test_time).R_S_tool;
    EXPECT_GT(now.dot(last), 0);
    last = now;
    if (i % 5 == 4) ASSERT_TRUE(arm_.Command(tip_));
  }
}

TEST_F(TurningArmTest, HoldingHoldsTheMeasuredRotation) {
  ASSERT_TRUE(arm_.Command(tip_));
  arm_.Turn(AngleAxisd(1, Vector3d::UnitX()) * start_);
  Turn(0.2);
  const Quaterniond held = rotation_;
  arm_.Hold();
  EXPECT_LT(arm_.Aim(test_time).R_S_tool->angularDistance(held), 1e-7);
  Turn(0.5);
  ASSERT_TRUE(arm_.Command(tip_));
  Turn(0.5);
  EXPECT_LT(rotation_.angularDistance(held), 1e-7) << "only the tip was sent";
  EXPECT_EQ(arm_.Rotation()->angularDistance(rotation_) < 1e-7, true);
}

// A slave that slept must not make up for it in one step.
TEST_F(StreamedManipulatorTest, AStallOfTheSlaveCausesNoJumpOfTheArm) {
  Drive(0.1);
  ASSERT_TRUE(arm_.Command({0.1, 0, 0}));
  const Vector3d before = Drive(0.01);
  Pass(0.035);
  EXPECT_LE((arm_.Aim(test_time).p_S_tip - before).norm(), 0.05 * options_.max_speed);
}

TEST_F(StreamedManipulatorTest, ASilentDriverIsAFaultAndItsReturnNoMotion) {
  Drive(0.1);
  ASSERT_TRUE(arm_.Command({0.05, 0, 0}));
  Drive(0.1);
  Pass(0.041);
  EXPECT_TRUE(arm_.is_faulty());
  EXPECT_THAT(arm_.health()->fault, HasSubstr("silent for 0.04"));
  EXPECT_EQ(arm_.Aim(test_time).motion, Motion::kHold);
  EXPECT_FALSE(arm_.Command({0.05, 0, 0}));
  Drive(0.01);
  EXPECT_TRUE(arm_.is_faulty()) << "however short, somebody shall have seen it";
  const Vector3d held = tip_;
  Drive(0.1);
  EXPECT_FALSE(arm_.is_faulty());
  EXPECT_EQ(tip_, held);
}

TEST_F(StreamedManipulatorTest, AnEmergencyStopIsReportedToTheDriverAndOutlivesAFault) {
  Drive(0.1);
  ASSERT_TRUE(arm_.Command({0.05, 0, 0}));
  Drive(0.1);
  arm_.Stop();
  EXPECT_EQ(arm_.Aim(test_time).motion, Motion::kStop);
  Pass(1);
  Drive(0.1);
  EXPECT_EQ(arm_.Aim(test_time).motion, Motion::kStop);
  arm_.Hold();
  EXPECT_EQ(arm_.Aim(test_time).motion, Motion::kHold);
}

// The commanded position is ahead of the arm: the arm is held at its own position.
TEST_F(StreamedManipulatorTest, AHeldArmStaysAtItsMeasuredPosition) {
  Drive(0.1);
  ASSERT_TRUE(arm_.Command({0.05, 0, 0}));
  Drive(0.2);
  const Vector3d measured = tip_ - Vector3d(3e-4, 0, 0);  // the arm yields
  Pass(kReportPeriod);
  ASSERT_EQ(Report(measured), std::nullopt);
  arm_.Hold();
  EXPECT_EQ(arm_.Aim(test_time).p_S_tip, measured);
  Pass(kReportPeriod);
  ASSERT_EQ(Report(measured - Vector3d(1e-4, 0, 0)), std::nullopt);
  arm_.Hold();
  EXPECT_EQ(arm_.Aim(test_time).p_S_tip, measured);
}

// The arm was moved externally while it was stopped; it is not pulled back.
TEST_F(StreamedManipulatorTest, CommandsBeginWhereTheArmIs) {
  Drive(0.1);
  tip_ += Vector3d(0, 0.01, 0);
  for (int i = 0; i < 400; ++i)
    Drive(kReportPeriod);  // first far from the last position, later accepted
  ASSERT_TRUE(arm_.Command(tip_));
  Pass(kReportPeriod);
  EXPECT_TRUE((arm_.Aim(test_time).p_S_tip - tip_).isZero(1e-12));
}

struct FaultyReading {
  const char* name;
  void (*apply)(ArmReading*);
  const char* words;
};

class FaultyReadingTest : public StreamedManipulatorTest,
                          public testing::WithParamInterface<FaultyReading> {};

TEST_P(FaultyReadingTest, IsAFaultInWordsAndNoPlace) {
  Drive(0.1);
  ASSERT_TRUE(arm_.Command({0.05, 0, 0}));
  Drive(0.1);
  const Vector3d before = arm_.Tip();
  Pass(kReportPeriod);
  ArmReading reading = Reading(tip_);
  GetParam().apply(&reading);
  ASSERT_EQ(arm_.Take(kDriver, "", reading, test_time), std::nullopt);
  EXPECT_TRUE(arm_.is_faulty());
  EXPECT_THAT(arm_.health()->fault, HasSubstr(GetParam().words));
  EXPECT_LT((arm_.Tip() - before).norm(), 1e-3);
  EXPECT_EQ(arm_.Aim(test_time).motion, Motion::kHold);
}

INSTANTIATE_TEST_SUITE_P(
    All, FaultyReadingTest,
    testing::Values(FaultyReading{"Fault", [](ArmReading* r) { r->fault = "axis 3 is hot"; },
                                  "reports: axis 3 is hot"},
                    FaultyReading{"Leap", [](ArmReading* r) { r->p_S_tip.y() += 0.02; },
                                  "20 mm from"},
                    FaultyReading{"Outside", [](ArmReading* r) { r->p_S_tip.x() = 0.15; },
                                  "outside its workspace"}),
    [](const auto& info) { return info.param.name; });

TEST_F(StreamedManipulatorTest, ReadingsOutOfOrderAreRefusedInWords) {
  Drive(0.1);
  Pass(kReportPeriod);
  const auto refusal = [this](const ArmReading& reading) {
    return arm_.Take(kDriver, "", reading, test_time).value_or(DriverRefusal{}).why;
  };
  ArmReading old = Reading(tip_), earlier = Reading(tip_);
  old.sequence = 1;
  earlier.measured_at -= Seconds(1);
  EXPECT_THAT(refusal(old), HasSubstr("sequence = 1: expected one above the last"));
  EXPECT_THAT(refusal(earlier), HasSubstr("measured_at: expected a time that increases"));
}

TEST_F(StreamedManipulatorTest, OneDriverAtATime) {
  Drive(0.1);
  Pass(kReportPeriod);
  ArmReading other = Reading(tip_);
  EXPECT_THAT(arm_.Take(kOther, "b", other, test_time).value_or(DriverRefusal{}).why,
              HasSubstr("the manipulator is driven by a driver"));
  arm_.Leave(kDriver);
  EXPECT_TRUE(arm_.is_faulty());
  other.sequence = 1;  // the numbers of each stream begin at 1
  const auto before = arm_.frame();
  EXPECT_EQ(arm_.Take(kOther, "b", other, test_time), std::nullopt);
  EXPECT_EQ(arm_.health()->driver, "b");
  EXPECT_NE(arm_.frame(), before);
}

TEST_F(StreamedManipulatorTest, AForceIsReportedOnlyWhileTheArmIsWell) {
  Drive(0.1);
  Pass(kReportPeriod);
  ArmReading reading = Reading(tip_);
  reading.force = Vector3d(0, 1, 0);
  ASSERT_EQ(arm_.Take(kDriver, "", reading, test_time), std::nullopt);
  EXPECT_EQ(arm_.measured_force(), Vector3d(0, 1, 0));
  Pass(0.05);
  EXPECT_EQ(arm_.measured_force(), std::nullopt);
}

// A linear arm p = scale u(t - lag) of a sine: both are found to a per cent and half a millisecond.
TEST(ArmFitTest, FindsLagAndScaleOfAnArmThatMoves) {
  constexpr double kLag = 0.012, kScale = 1.03, kRate = 2 * std::numbers::pi * 0.5, kWay = 5e-3;
  ArmFit fit;
  EXPECT_FALSE(fit.found());
  for (double t = 0; t < 4; t += kReportPeriod) {
    const auto place = [&](double at) { return Vector3d(0, kWay * std::sin(kRate * at), 0); };
    const Vector3d velocity(0, kWay * kRate * std::cos(kRate * t), 0);
    fit.Add(kScale * place(t - kLag) + Vector3d(1, 2, 3), place(t), velocity, kReportPeriod);
  }
  ASSERT_TRUE(fit.found());
  EXPECT_NEAR(fit.found()->lag, kLag, 0.5e-3);
  EXPECT_NEAR(fit.found()->scale, kScale, 0.01);
}

}  // namespace
}  // namespace palpate
