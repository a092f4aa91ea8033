// What every simulated site has in common, asked through the one interface that all else sees.
#include "slave/site/environment/simulated_environment.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

Scene Shipped(const std::string& name) {
  return LoadScene(SourcePath("/deploy/scenes/" + name + ".yaml"));
}

class SimulatedEnvironmentTest : public ::testing::TestWithParam<const char*> {};

TEST_P(SimulatedEnvironmentTest, TheToolIsWhereItWasCarriedAndFeelsNothingInThinAir) {
  const Scene scene = Shipped(GetParam());
  const auto environment = MakeSimulatedEnvironment(scene);
  ASSERT_NE(environment, nullptr);
  const Vector3d home = environment->truth().p_S_tip;
  EXPECT_LT((home - scene.manipulator.home).norm(), 1e-9);
  const Vector3d aside = home + Vector3d(1e-4, 0, 0);
  environment->MoveTool(aside);
  const Truth truth = environment->truth();
  EXPECT_LT((truth.p_S_tip - aside).norm(), 1e-9);
  EXPECT_FALSE(truth.in_contact);
  EXPECT_EQ(truth.force.norm(), 0);
  environment->MoveTool(Vector3d::Constant(std::nan("")));
  EXPECT_LT((environment->truth().p_S_tip - aside).norm(), 1e-9) << "no place";
}

TEST_P(SimulatedEnvironmentTest, OneKindOfSourceShowsItOnAClockOfItsOwn) {
  const Scene scene = Shipped(GetParam());
  const auto environment = MakeSimulatedEnvironment(scene);
  const Pace pace{.is_live = false};
  const auto camera = environment->OpenCamera(scene, pace);
  const auto pair = environment->OpenPair(scene, pace);
  const auto fingertips = environment->OpenFingertips(scene, pace);
  EXPECT_EQ(camera != nullptr, scene.sense.Find<Camera>() != nullptr);
  EXPECT_EQ(pair != nullptr, scene.sense.Find<StereoCameras>() != nullptr);
  EXPECT_EQ(fingertips != nullptr, scene.sense.Find<Tactile>() != nullptr);
  if (camera) {
    EXPECT_EQ(camera->Next({})->sensed_at, Time{});
  }
  if (pair) {
    EXPECT_EQ(pair->Next({})->sensed_at, Time{});
  }
  if (fingertips) {
    EXPECT_EQ(fingertips->Next({})->sensed_at, Time{});
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, SimulatedEnvironmentTest,
                         ::testing::Values("silicone-block", "rubber-membrane", "foam-bar"),
                         [](const auto& shipped) {
                           std::string name = shipped.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(WorldOfRecordingsTest, ARealSiteIsNoWorld) {
  Scene scene = Shipped("silicone-block");
  scene.sense.Find<Camera>()->source = Camera::Source::kFiles;
  EXPECT_EQ(MakeSimulatedEnvironment(scene), nullptr);
}

}  // namespace
}  // namespace palpate
