#include "master/device/pointer.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kPointerSpeed = 0.05;  // [m/s]
const Eigen::Vector3d kAim(0.02, -0.01, 0);

// A web page that sends its target every 20 ms, and a loop that reads it every millisecond.
class Stage {
 public:
  explicit Stage(double speed = kPointerSpeed) : pointer(speed) {}

  // Runs for `seconds`. `says`: whether the page sends messages.
  DeviceReading Run(double seconds, const Eigen::Vector3d& aim, bool engaged, bool says = true) {
    DeviceReading reading;
    for (int i = 0; i < std::lround(1000 * seconds); ++i, ++ms_) {
      const Time now = Time{std::chrono::hours(1)} + std::chrono::milliseconds(ms_);
      if (says && i % 20 == 0) {
        pointer.Aim({aim, page, engaged, now, static_cast<double>(ms_), gap});
      }
      reading = pointer.Read(now);
      fastest = std::max(fastest, reading.v_M.norm());
      pointer.WriteForce(force);
    }
    return reading;
  }

  Pointer pointer;
  std::uint64_t page = 1;
  double gap = 0;  // of the page's timer [s]
  Eigen::Vector3d force{0, 0, 0};
  double fastest = 0;

 private:
  int ms_ = 0;
};

struct PointerTest : testing::Test {
  Stage stage;
};

TEST_F(PointerTest, FollowsTheTargetWithinTheSpeedLimit) {
  stage.Run(0.1, {0, 0, 0}, true);
  const DeviceReading reading = stage.Run(2, kAim, true);
  EXPECT_TRUE(reading.engaged);
  EXPECT_NEAR((reading.p_M - kAim).norm(), 0, 1e-6);
  // Reference: (2 z w s + w^2) / (s^2 + 2 z w s + w^2) overshoots a step, here of speed, by 21 % at
  // the arm's z = 0.7.
  EXPECT_LT(stage.fastest, 1.22 * kPointerSpeed);
}

// A page that was loaded again aims at zero, wherever the tool is.
TEST_F(PointerTest, EngagingMovesNothing) {
  stage.Run(2, {0, 0, 0}, true);
  const Eigen::Vector3d before = stage.Run(2, kAim, true).p_M;
  stage.Run(0.2, kAim, false);
  const DeviceReading again = stage.Run(1, {0.5, 0.5, 0.5}, true);
  EXPECT_TRUE(again.engaged);
  EXPECT_NEAR((again.p_M - before).norm(), 0, 1e-6);
}

TEST_F(PointerTest, SilenceLetsGo) {
  EXPECT_TRUE(stage.Run(0.5, kAim, true).engaged);
  EXPECT_TRUE(stage.Run(0.22, kAim, true, false).engaged);
  const DeviceReading silent = stage.Run(0.05, kAim, true, false);
  EXPECT_FALSE(silent.engaged);
  const DeviceReading later = stage.Run(1, kAim, true, false);
  EXPECT_LT((later.p_M - silent.p_M).norm(), 0.002) << "the arm comes to rest where it was let go";
  EXPECT_FALSE(later.engaged);
}

// Only the page's own delay prolongs the limit, and never beyond kMaxSilence.
TEST_F(PointerTest, TheLimitFollowsTheBrowserWithinItsRange) {
  EXPECT_EQ(Pointer::MaxSilence(0.02), Pointer::kMinSilence);
  EXPECT_EQ(Pointer::MaxSilence(0.3), 0.6);
  EXPECT_EQ(Pointer::MaxSilence(1e9), Pointer::kMaxSilence);
  stage.pointer.Aim({kAim, 1, true, Time{std::chrono::hours(1)}, 0, 1e9});
  stage.Run(1.2, kAim, true, false);
  EXPECT_FALSE(stage.pointer.holds()) << "whatever the page requests";
}

TEST_F(PointerTest, ALateBrowserGoesOnWithoutANewEngagement) {
  stage.gap = 0.3;
  stage.Run(0.1, {0, 0, 0}, true);
  stage.Run(0.5, kAim, true);
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(stage.Run(0.55, kAim, true, false).engaged);
    EXPECT_TRUE(stage.Run(0.02, kAim, true).engaged);
  }
  EXPECT_NEAR((stage.Run(2, kAim, true).p_M - kAim).norm(), 0, 1e-6);
  EXPECT_EQ(stage.pointer.silence(), 0);
  EXPECT_FALSE(stage.Run(0.65, kAim, true, false).engaged);
}

// The target is 22 mm away, of which the speed allows 5 mm in kHoldAfter. The arm overshoots.
TEST_F(PointerTest, ASilentPageMovesNothing) {
  stage.gap = 0.5;
  stage.Run(0.1, {0, 0, 0}, true);
  stage.Run(0.02, kAim, true);
  stage.Run(0.4, kAim, true, false);
  const DeviceReading before = stage.Run(0.001, kAim, true, false);
  const DeviceReading after = stage.Run(0.4, kAim, true, false);
  EXPECT_TRUE(after.engaged);
  EXPECT_LT(after.p_M.norm(), kPointerSpeed * 0.12);
  EXPECT_LT((after.p_M - before.p_M).norm(), 1e-4);
}

// Reference: the time for which the stage sends nothing; a reading per millisecond.
TEST_F(PointerTest, TheSilenceThatEndedAnEngagementIsMeasured) {
  stage.Run(0.5, kAim, true);
  EXPECT_EQ(stage.pointer.silence(), 0);
  stage.Run(0.7, kAim, true, false);
  stage.Run(0.5, kAim, true);
  EXPECT_NEAR(stage.pointer.silence(), 0.72, 0.002) << "the last message is 20 ms older";
  stage.Run(0.02, kAim, false);
  stage.Run(0.02, kAim, true);
  EXPECT_EQ(stage.pointer.silence(), 0);
}

TEST_F(PointerTest, AReturningPageIsDisengagedUntilItIsPressedAgain) {
  stage.Run(0.5, kAim, true);
  stage.Run(0.5, kAim, true, false);
  EXPECT_FALSE(stage.Run(0.5, kAim, true).engaged);
  EXPECT_FALSE(stage.pointer.holds());
  stage.Run(0.05, kAim, false);
  EXPECT_TRUE(stage.Run(0.05, kAim, true).engaged);
  EXPECT_TRUE(stage.pointer.holds());
}

// Its targets count from its own origin, and it was never released.
TEST_F(PointerTest, AnotherPageHoldsAfterASilentOneAndMovesNothing) {
  const Eigen::Vector3d before = stage.Run(2, kAim, true).p_M;
  stage.Run(0.5, kAim, true, false);
  stage.page = 2;
  const DeviceReading taken = stage.Run(0.5, {0, 0, 0}, true);
  EXPECT_TRUE(taken.engaged);
  EXPECT_NEAR((taken.p_M - before).norm(), 0, 1e-4);
}

}  // namespace
}  // namespace palpate
