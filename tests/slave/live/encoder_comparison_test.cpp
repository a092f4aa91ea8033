// A live slave before a camera that shows a free tool, while the object or the camera moves. The
// manipulator's encoders show which of the two it is.
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared/wire/enum_names.h"
#include "slave/live/live_slave.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/simulator/simulated_devices.h"
#include "tests/support/eventually.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

constexpr double kHalfPixel = 0.18e-3;  // [m]

class EncoderComparisonTest : public testing::Test {
 protected:
  static Scene Block(const std::vector<std::string>& overrides) {
    std::vector<std::string> all{"model.elements=60", "sense.camera.rate=15 Hz"};
    all.insert(all.end(), overrides.begin(), overrides.end());
    return LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"), all);
  }
  // The states of the next `count` images.
  static std::vector<SlaveState> Watch(Slave* slave, std::size_t count) {
    std::vector<SlaveState> seen;
    EXPECT_TRUE(Eventually([&] {
      const SlaveState state = slave->Compose(Clock::now());
      if (seen.empty() || state.sample != seen.back().sample) seen.push_back(state);
      return seen.size() == count;
    }));
    return seen;
  }
  // Returns the fraction of `seen` in which no check fails and the tip is at `p_S`. On a busy
  // machine some images are stale, or the manipulator's driver is silent.
  static double ShareAt(const std::vector<SlaveState>& seen, const Eigen::Vector3d& p_S) {
    const auto is_right = [&](const SlaveState& state) {
      const bool passes =
          state.check == FailedCheck::kNone || state.check == FailedCheck::kArmFault;
      return passes && state.force && (state.p_S_tip - p_S).norm() < kHalfPixel;
    };
    return static_cast<double>(std::ranges::count_if(seen, is_right)) /
           static_cast<double>(seen.size());
  }
  static constexpr std::size_t kImages = 90;
  // Images until it is known whether object or tool moves.
  static constexpr std::size_t kUndecided = 20;
};

// If the motion of the object were attributed to the camera, the tip would move by up to 2 mm.
TEST_F(EncoderComparisonTest, AToolAtRestBesideAnObjectThatMovesStaysValidWhereItIs) {
  const Scene scene = Block({"site.motion={amplitude: [0 mm, 2 mm], period: 4 s}"});
  const auto slave = MakeLiveSlave(scene);
  const SimulatedDevices devices(scene, slave.get());
  // In the first image the object may be anywhere on its path; the tip is measured relative to it.
  Watch(slave.get(), kUndecided);
  const std::vector<SlaveState> seen = Watch(slave.get(), kImages);
  const Eigen::Vector3d p_S_tip = seen[kImages / 2].p_S_tip;
  EXPECT_LT((p_S_tip - scene.manipulator.home).norm(), 2e-3);
  EXPECT_GT(ShareAt(seen, p_S_tip), 0.95);
}

// The tool has not moved relative to the object. If the camera's motion of 8 px were attributed to
// the object, the tip would move by 2.8 mm.
TEST_F(EncoderComparisonTest, ACameraThatIsBumpedALittleMovesNeitherToolNorObject) {
  const Scene scene = Block({});
  const auto slave = MakeLiveSlave(scene);
  SimulatedDevices devices(scene, slave.get());
  Watch(slave.get(), kUndecided);
  devices.BumpCamera(8);
  Watch(slave.get(), kUndecided);
  EXPECT_GT(ShareAt(Watch(slave.get(), kImages), scene.manipulator.home), 0.95);
}

class BumpedCameraTest : public EncoderComparisonTest, public testing::WithParamInterface<int> {};

// Beyond what is compensated the tool seems to be in the object, or far above it.
TEST_P(BumpedCameraTest, TrackingComesBackAfterOneCall) {
  const Scene scene = Block({});
  const auto slave = MakeLiveSlave(scene);
  SimulatedDevices devices(scene, slave.get());
  Watch(slave.get(), kUndecided);
  devices.BumpCamera(GetParam());
  Watch(slave.get(), kUndecided);
  ASSERT_NE(slave->Compose(Clock::now()).validity, Validity::kValid);
  ASSERT_NO_THROW(slave->ReinitializeTracking());
  EXPECT_TRUE(
      Eventually([&] { return slave->Compose(Clock::now()).validity == Validity::kValid; }));
  const double displacement = scene.sense.Find<Camera>()->pixel * GetParam();
  for (const SlaveState& state : Watch(slave.get(), kUndecided)) {
    EXPECT_TRUE(state.check == FailedCheck::kNone || state.check == FailedCheck::kArmFault)
        << ToString(state.check);
    EXPECT_EQ(state.depth, 0);
    EXPECT_NEAR(state.p_S_tip.y() - scene.manipulator.home.y(), -displacement, kHalfPixel);
  }
  EXPECT_TRUE(slave->Status().cameras->trouble.empty());
}
INSTANTIATE_TEST_SUITE_P(BothWays, BumpedCameraTest, testing::Values(50, -60));

// One image per second is tried, and the alarm reports that it failed.
TEST_F(EncoderComparisonTest, TrackingThatCannotBeginAgainIsAnAlarmUntilItDoes) {
  const Scene scene = Block({});
  const auto slave = MakeLiveSlave(scene);
  SimulatedDevices devices(scene, slave.get());
  Watch(slave.get(), kUndecided);
  devices.CoverCamera(true);
  ASSERT_TRUE(
      Eventually([&] { return slave->Compose(Clock::now()).validity == Validity::kTrackingLost; }));
  slave->ReinitializeTracking();
  const auto is_reported = [&] {
    const std::vector<std::string> alarms = slave->Status().alarms;
    return std::ranges::any_of(alarms, [](const std::string& alarm) {
      return alarm.find("tracking is not reinitialized yet") != std::string::npos;
    });
  };
  EXPECT_TRUE(Eventually(is_reported));
  devices.CoverCamera(false);
  EXPECT_TRUE(Eventually(
      [&] { return !is_reported() && slave->Compose(Clock::now()).validity == Validity::kValid; }));
}

}  // namespace
}  // namespace palpate
