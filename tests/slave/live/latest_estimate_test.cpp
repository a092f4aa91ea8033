#include "slave/live/latest_estimate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/live/operator_port.h"
#include "slave/live/slave.h"
#include "tests/slave/live/operator_port_fixture.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kEstimateRate = 60;  // [Hz]

SlaveStatus StatusAfter(double silence, double idle_wait) {
  LatestEstimate newest(kEstimateRate, Eigen::Vector3d::Zero());
  ContactEstimate estimate;
  estimate.validity = Validity::kValid;
  estimate.force = Eigen::Vector3d::Zero();
  estimate.sensed_at = Clock::now() - Seconds(silence);
  newest.Put(estimate);
  newest.SetIdleWait(idle_wait);
  SlaveStatus status;
  newest.Describe(&status);
  return status;
}

TEST(LatestEstimateTest, ASensorThatIsSilentIsAnAlarmInWords) {
  const SlaveStatus status = StatusAfter(10, 0);
  EXPECT_EQ(status.validity, Validity::kStale);
  EXPECT_THAT(status.alarms, ElementsAre(HasSubstr("no sample from the sensor for 10 s")));
}

TEST(LatestEstimateTest, NoSamplesTraceIsSentTwiceOrLeftOutOfTheNewest) {
  LatestEstimate newest(kEstimateRate, Eigen::Vector3d::Zero());
  const Time begin = Clock::now();
  for (int i = 1; i <= 300; ++i) {
    ContactEstimate estimate;
    estimate.sample = static_cast<std::uint64_t>(i);
    estimate.sensed_at = begin + std::chrono::milliseconds(i);
    newest.Put(estimate, {.acquired_at = estimate.sensed_at});
  }
  const auto since = [&](int i) {
    return newest.TracesSince(begin + std::chrono::milliseconds(i));
  };
  ASSERT_EQ(since(298).size(), 2U);
  EXPECT_EQ(since(298).front().sample, 299U);
  EXPECT_EQ(since(298).back().sensed_at, begin + std::chrono::milliseconds(300));
  EXPECT_GE(since(298).back().solved_at, begin);
  EXPECT_THAT(since(300), IsEmpty());
  EXPECT_LT(since(0).size(), 300U) << "nothing grows for ever";
  EXPECT_EQ(since(0).back().sample, 300U);
}

// The publisher asks with the time at which it woke up; it may be delayed before it reads the
// estimate. No state may be sent before it was sensed.
TEST_F(OperatorPortTest, AStateIsNotSentBeforeItsSampleWasTaken) {
  LatestEstimate newest(kEstimateRate, Eigen::Vector3d::Zero());
  ContactEstimate estimate;
  estimate.sensed_at = now_ + std::chrono::milliseconds(1);
  newest.Put(estimate);
  EXPECT_EQ(newest.Compose(port_, now_).sent_at, estimate.sensed_at);
  EXPECT_EQ(newest.Compose(port_, estimate.sensed_at + std::chrono::milliseconds(1)).sent_at,
            estimate.sensed_at + std::chrono::milliseconds(1));
}

// A tip that was lost in contact, or a moved camera, must not block a change of settings for ever.
// Other flagged contacts are contacts.
TEST(LatestEstimateTest, OnlyAContactWithoutAKnownRestStateIsNone) {
  LatestEstimate newest(kEstimateRate, Eigen::Vector3d::Zero());
  ContactEstimate estimate;
  estimate.depth = 2e-3;
  const auto touches = [&](const Verdict& verdict) {
    estimate.force = Eigen::Vector3d::Zero();
    estimate.Set(verdict);
    if (!IsForceKnown(verdict.validity)) estimate.force.reset();
    newest.Put(estimate);
    EXPECT_TRUE(newest.Touches());
    return newest.TouchesAsFarAsKnown();
  };
  EXPECT_TRUE(touches({Validity::kValid}));
  EXPECT_TRUE(touches({Validity::kFailed}));
  EXPECT_TRUE(touches({Validity::kExtrapolated, FailedCheck::kModelRange}));
  EXPECT_TRUE(touches({Validity::kExtrapolated, FailedCheck::kIndentation}));
  EXPECT_TRUE(touches({Validity::kExtrapolated, FailedCheck::kArm}));
  EXPECT_FALSE(touches({Validity::kExtrapolated, FailedCheck::kRegistration}));
  EXPECT_FALSE(touches({Validity::kExtrapolated, FailedCheck::kCameraMotion}));
  EXPECT_FALSE(touches({Validity::kExtrapolated, FailedCheck::kRestDrift}));
  EXPECT_FALSE(touches({Validity::kTrackingLost, FailedCheck::kTip}));
}

TEST(LatestEstimateTest, NoKindOfAlarmCrowdsOutAnother) {
  LatestEstimate newest(kEstimateRate, Eigen::Vector3d::Zero());
  for (int i = 1; i <= 20; ++i) {
    newest.RaiseAlarm("model range", "presses are " + std::to_string(i) + " mm deep");
  }
  newest.RaiseAlarm("stop record", "the stop is not saved");
  SlaveStatus status;
  newest.Describe(&status);
  EXPECT_THAT(status.alarms,
              ElementsAre("presses are 20 mm deep (raised 20 times)", "the stop is not saved"));
}

// Without a client samples are rare, which is no silence of the sensor.
TEST(LatestEstimateTest, ARestIsNoSilence) {
  const SlaveStatus status = StatusAfter(10, 20);
  EXPECT_EQ(status.validity, Validity::kValid);
  EXPECT_THAT(status.alarms, IsEmpty());
}

}  // namespace
}  // namespace palpate
