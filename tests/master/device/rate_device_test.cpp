#include "master/device/rate/rate_device.h"

#include <gtest/gtest.h>

#include "master/device/rate/rumble_pace.h"

namespace palpate {
namespace {

const Time kRateStart{std::chrono::hours(1)};
constexpr double kFullSpeed = 0.02;  // [m/s]

Time RateTime(double t) {
  return kRateStart + Seconds(t);
}

// A source that returns the value set by the test.
struct Scripted final : RateSource {
  RateInput Poll(Time /*now*/) override { return input; }
  void Cue(double share, Time /*now*/) override { cue = share; }
  [[nodiscard]] std::string description() const override { return "scripted"; }
  RateInput input;
  double cue = 0;
};

class RateDeviceTest : public testing::Test {
 protected:
  RateDeviceTest()
      : source_(new Scripted), device_(std::unique_ptr<RateSource>(source_), kFullSpeed, false) {}

  // Ticks of 1 ms for `seconds`; the source is polled every 5 ms if it `speaks`.
  DeviceReading Run(double seconds, bool speaks = true) {
    DeviceReading reading;
    for (int i = 0; i < std::lround(1000 * seconds); ++i, ++ms_) {
      const Time now = RateTime(0.001 * ms_);
      if (speaks && ms_ % 5 == 0) device_.Poll(now);
      reading = device_.Read(now);
      device_.WriteForce(force_);
    }
    return reading;
  }

  Scripted* source_;
  RateDevice device_;
  Eigen::Vector3d force_{0, 0, 0};
  int ms_ = 0;
};

TEST_F(RateDeviceTest, YieldsToTheForceAndShowsIt) {
  source_->input.engaged = true;
  force_ = {0, 3, 0};
  EXPECT_NEAR(Run(2).p_M.y(), 3 / Arm().stiffness, 1e-6);
  EXPECT_NEAR(source_->cue, 3.0 / 12, 1e-9);
}

// Reference: the motion ends after 20 ms of silence, the engagement after 100 ms.
TEST_F(RateDeviceTest, ASilentSourceStopsTheMotionAndThenDisengages) {
  source_->input.engaged = true;
  source_->input.share = {1, 0, 0};
  Run(1);
  const double before = Run(0.090, false).p_M.x();
  EXPECT_NEAR(Run(0.005, false).p_M.x(), before, 1e-4);
  const DeviceReading silent = Run(0.020, false);
  EXPECT_EQ(silent.status.fault, DeviceFault::kSilent);
  EXPECT_FALSE(silent.engaged);
  EXPECT_FALSE(Run(0.1).engaged) << "the switch was never opened";
}

// Reference: at most one command in 50 ms, one in 100 ms during a rumble, and a zero at its end.
TEST(RumblePaceTest, SendsChangesAtMostEveryFiftyMillisecondsAndRepeats) {
  RumblePace pace;
  EXPECT_FALSE(pace.Send(0, RateTime(0)));
  EXPECT_TRUE(pace.Send(0.5, RateTime(0.005)));
  EXPECT_FALSE(pace.Send(0.7, RateTime(0.050)));
  EXPECT_TRUE(pace.Send(0.7, RateTime(0.056)));
  EXPECT_FALSE(pace.Send(0.7, RateTime(0.150)));
  EXPECT_TRUE(pace.Send(0.7, RateTime(0.160)));
  EXPECT_FALSE(pace.Send(0.01, RateTime(0.165)));
  EXPECT_TRUE(pace.Send(0.01, RateTime(0.215))) << "a force in the dead zone is none";
  EXPECT_FALSE(pace.Send(0, RateTime(1)));
}

}  // namespace
}  // namespace palpate
