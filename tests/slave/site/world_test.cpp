// What every simulated site has in common, asked through the one interface that all else sees.
#include "slave/site/world.h"

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

class WorldTest : public ::testing::TestWithParam<const char*> {};

TEST_P(WorldTest, TheToolIsWhereItWasCarriedAndFeelsNothingInThinAir) {
  const Scene scene = Shipped(GetParam());
  const auto world = MakeWorld(scene);
  ASSERT_NE(world, nullptr);
  const Vector3d home = world->truth().p_S_tip;
  EXPECT_LT((home - scene.manipulator.home).norm(), 1e-9);
  const Vector3d aside = home + Vector3d(1e-4, 0, 0);
  world->MoveTool(aside);
  const Truth truth = world->truth();
  EXPECT_LT((truth.p_S_tip - aside).norm(), 1e-9);
  EXPECT_FALSE(truth.in_contact);
  EXPECT_EQ(truth.force.norm(), 0);
  world->MoveTool(Vector3d::Constant(std::nan("")));
  EXPECT_LT((world->truth().p_S_tip - aside).norm(), 1e-9) << "no place";
}

TEST_P(WorldTest, OneKindOfSourceShowsItOnAClockOfItsOwn) {
  const Scene scene = Shipped(GetParam());
  const auto world = MakeWorld(scene);
  const Pace pace{.is_live = false};
  const auto camera = world->OpenCamera(scene, pace);
  const auto pair = world->OpenPair(scene, pace);
  const auto fingertips = world->OpenFingertips(scene, pace);
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

INSTANTIATE_TEST_SUITE_P(Shipped, WorldTest,
                         ::testing::Values("silicone-block", "rubber-membrane", "foam-bar"),
                         [](const auto& shipped) {
                           std::string name = shipped.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(WorldOfRecordingsTest, ARealSiteIsNoWorld) {
  Scene scene = Shipped("silicone-block");
  scene.sense.Find<Camera>()->source = Camera::Source::kFiles;
  EXPECT_EQ(MakeWorld(scene), nullptr);
}

}  // namespace
}  // namespace palpate
