#include <chrono>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/site/points/pair_rig.h"
#include "slave/site/points/scripted_membrane.h"
#include "tests/slave/site/points/membrane_scenes.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using site::MembraneScene;
using site::TargetScene;

// Reference: the geometry of two cameras that look at one point from the same distance.
TEST(SimulatedRig, BothCamerasLookAtTheObjectsOriginABaselineApart) {
  for (const double baseline : {0.005, 0.06, 0.2}) {
    Scene scene = MembraneScene();
    scene.sense.Find<StereoCameras>()->baseline = baseline;
    scene.sense.Find<StereoCameras>()->X_SL = site::LeftEye(scene.object.X_SO, baseline);
    const StereoRig rig = SimulatedRig(scene);
    const Vector3d p_L =
        scene.sense.Find<StereoCameras>()->X_SL.inverse() * scene.object.X_SO.translation();
    const Vector3d p_R = rig.X_RL * p_L;
    EXPECT_NEAR(rig.baseline(), baseline, 1e-15);
    EXPECT_NEAR(p_L.head<2>().norm(), 0, 1e-12);
    EXPECT_NEAR(p_R.head<2>().norm(), 0, 1e-12);
    EXPECT_NEAR(p_R.z(), p_L.z(), 1e-12);
    const Vector3d p_L_right = rig.X_RL.inverse().translation();
    EXPECT_GT(p_L_right.x(), 0.9 * baseline) << "the right camera stands on the right";
    const auto in_left = Project(rig.left, p_L);
    ASSERT_TRUE(in_left);
    EXPECT_NEAR((*in_left - Eigen::Vector2d(319.5, 239.5)).norm(), 0, 1e-9);
  }
}

TEST(LivePairs, ComeAtTheRateAndStopAtOnce) {
  Scene scene = MembraneScene();
  scene.sense.Find<StereoCameras>()->rate = 50;
  StereoSite site(scene, site::kCoarse);
  const auto source = site.OpenPair(scene, {});
  Time last{};
  for (std::uint64_t k = 1; k <= 5; ++k) {
    const auto pair = source->Next({});
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->sequence, k);
    EXPECT_EQ(pair->left.size(), cv::Size(640, 480));
    EXPECT_EQ(pair->right.type(), CV_8UC1);
    EXPECT_GT(pair->sensed_at, last);
    last = pair->sensed_at;
  }
  scene.sense.Find<StereoCameras>()->rate = 0.001;
  StereoSite slow_site(scene, site::kCoarse);
  const auto slow = slow_site.OpenPair(scene, {});
  std::stop_source stop;
  ASSERT_TRUE(slow->Next(stop.get_token()));
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    stop.request_stop();
  });
  EXPECT_FALSE(slow->Next(stop.get_token()));
}

// Reference: the script as its header tells it.
TEST(ScriptedMembrane, PressesInStepsOfHalfAMillimetreAndComesBack) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 1.2e-3;
  scene.manipulator.home = scene.object.X_SO * Vector3d(0.01, 0.005, 4e-3);
  MembraneScript script;
  script.rest = 3;
  script.dwell = 2;
  StereoSite site(scene, site::kCoarse);
  ScriptedMembrane source(site, scene, script);
  EXPECT_THAT(source.depths(), testing::ElementsAre(0, 0.5e-3, 1e-3, 1.2e-3));
  const std::vector<double> depths{-1,   -1,     -1,     0,    0,      0.5e-3, 0.5e-3, 1e-3,
                                   1e-3, 1.2e-3, 1.2e-3, 1e-3, 0.5e-3, 0,      -1,     -1};
  const std::vector<int> steps{-1, -1, -1, 0, 0, 1, 1, 2, 2, 3, 3, -1, -1, -1, -1, -1};
  ASSERT_EQ(source.pairs(), depths.size());
  EXPECT_EQ(source.step(), -1);
  for (std::size_t k = 0; k < depths.size(); ++k) {
    const auto pair = source.Next({});
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->sequence, k + 1);
    EXPECT_NEAR(SecondsBetween(Time{}, pair->sensed_at), static_cast<double>(k) / 30, 1e-8);
    EXPECT_EQ(source.step(), steps[k]) << k;
    const Truth truth = site.truth();
    const Vector3d p_O = scene.object.X_SO.inverse() * truth.p_S_tip;
    EXPECT_NEAR(p_O.x(), 0.01, 1e-12);
    EXPECT_NEAR(p_O.y(), 0.005, 1e-12);
    EXPECT_NEAR(p_O.z(), depths[k] < 0 ? 4e-3 : -depths[k], 1e-12) << k;
    EXPECT_EQ(truth.force.norm() > 0, depths[k] > 1e-9) << k;
  }
  EXPECT_FALSE(source.Next({}));
  EXPECT_FALSE(source.Next({}));
}

TEST(ScriptedMembrane, OtherScalesAreDividedIntoTenSteps) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 0.5e-3;
  StereoSite site(scene, site::kCoarse);
  EXPECT_EQ(ScriptedMembrane(site, scene).depths().size(), 11U);
}

TEST(ScriptedMembrane, ATargetIsFollowedOnItsPath) {
  MembraneScript script;
  script.target_seconds = 0.2;
  StereoSite site(TargetScene());
  ScriptedMembrane source(site, TargetScene(), script);
  EXPECT_EQ(source.pairs(), 6U);
  for (int k = 0; k < 6; ++k) {
    ASSERT_TRUE(source.Next({}));
    EXPECT_NEAR(site.target()->seconds, k / 30.0, 1e-12);
    EXPECT_EQ(source.step(), -1);
  }
  EXPECT_FALSE(source.Next({}));
  EXPECT_EQ(ScriptedMembrane(site, TargetScene()).pairs(), 300U);
}

TEST(ScriptedMembrane, AHomeThatIsNotOverTheMembraneIsRefused) {
  for (const Vector3d& p_O : {Vector3d(0.04, 0, 4e-3), Vector3d(0, 0, -4e-3)}) {
    Scene scene = MembraneScene();
    scene.manipulator.home = scene.object.X_SO * p_O;
    EXPECT_THAT(Thrown<std::invalid_argument>([&] {
                  StereoSite site(scene, site::kCoarse);
                  const ScriptedMembrane source(site, scene);
                }),
                testing::HasSubstr("manipulator.home"));
  }
}

}  // namespace
}  // namespace palpate
