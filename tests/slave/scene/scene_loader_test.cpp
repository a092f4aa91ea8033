#include "slave/scene/scene_loader.h"

#include <gtest/gtest.h>

#include "tests/slave/scene/decimal_comma.h"
#include "tests/slave/scene/scene_file.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

Scene Load(const std::string& text, const std::vector<std::string>& overrides = {},
           SceneUse use = SceneUse::kFull) {
  const Scratch folder;
  return LoadScene(folder.Write("scene.yaml", text), overrides, use);
}

TEST(SceneLoaderTest, TheToolPointsFromHomeAtTheObject) {
  const struct {
    const char* home;
    Eigen::Vector2d direction;
  } kRows[] = {{"[40 mm, 50 mm, 0]", {0, -1}},
               {"[40 mm, -10 mm, 0]", {0, 1}},
               {"[-20 mm, 20 mm, 0]", {1, 0}},
               {"[100 mm, 45 mm, 0]", {-1, 0}}};
  for (const auto& row : kRows) {
    const Scene scene = Load(SmallScene(), {std::string("manipulator.home=") + row.home});
    EXPECT_EQ(scene.tool->direction, row.direction) << row.home;
  }
  EXPECT_TRUE(Load(SmallScene(), {"tool.direction=[3, 4]"})
                  .tool->direction.isApprox(Eigen::Vector2d(0.6, 0.8)));
}

TEST(SceneLoaderTest, OverridesReplaceAddAndReachIntoLists) {
  const Scene scene =
      Load(SmallSceneWith(5, "  fixed: [{side: bottom}, {side: top}]"),
           {"model.elements=60", "object.fixed.1.side=left", "operator.press.depth=3 mm",
            "site.misplacement=[1 mm, -2 mm]", "model.elements=61"});
  EXPECT_EQ(scene.model.elements, 61);  // the last one counts
  EXPECT_EQ(std::get<FixedSide>(scene.object.fixed.at(1).where).side, "left");
  EXPECT_DOUBLE_EQ(scene.operator_options.press_depth, 3e-3);
  EXPECT_TRUE(scene.site.misplacement.isApprox(Eigen::Vector2d(1e-3, -2e-3)));
}

TEST(SceneLoaderTest, ReadsEveryWayToFix) {
  const Scene scene = Load(
      SmallSceneWith(5, "  fixed: [{side: left}, {plane: {axis: y, at: 40 mm}}, {nodes: [0, 5]}]"));
  ASSERT_EQ(scene.object.fixed.size(), 3U);
  EXPECT_EQ(std::get<FixedSide>(scene.object.fixed[0].where).side, "left");
  EXPECT_EQ(std::get<FixedPlane>(scene.object.fixed[1].where).axis, 1);
  EXPECT_DOUBLE_EQ(std::get<FixedPlane>(scene.object.fixed[1].where).at, 0.04);
  EXPECT_EQ(std::get<FixedNodes>(scene.object.fixed[2].where).nodes, (std::vector{0, 5}));
}

// Definition: rotation about fixed x, y, z in turn: x to y by 90 degrees about z.
TEST(SceneLoaderTest, PosesTurnAboutFixedAxes) {
  const Scene scene = Load(SmallSceneWith(
      5, "  fixed: {side: bottom}\n  pose: {translation: [1, 2, 0], rotation: [0, 0, 90 deg]}"));
  const Eigen::Vector3d p_S = scene.object.X_SO * Eigen::Vector3d(1, 0, 0);
  EXPECT_LT((p_S - Eigen::Vector3d(1, 3, 0)).norm(), 1e-15);
  // The rotated block is 40 mm wide and 80 mm high; home is above its centre.
  EXPECT_NEAR(scene.manipulator.home.x(), 1 - 0.02, 1e-15);
  EXPECT_NEAR(scene.manipulator.home.y(), 2.08 + 0.07 * 0.08, 1e-15);
}

// R = R_z R_y R_x: a rotation by 90 degrees about x and then about z maps y to z, and z to -y and
// then to x.
TEST(SceneLoaderTest, TheHandsRotationTakesXFirst) {
  const Scene scene = Load(SmallScene(), {"operator.rotation=[90 deg, 0, 90 deg]"});
  const Eigen::Matrix3d& R_SM = scene.operator_options.transform.R_SM;
  EXPECT_LT((R_SM * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  EXPECT_LT((R_SM * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-15);
}

TEST(SceneLoaderTest, ReadsPolygonsAndContourFiles) {
  const Scene polygon = Load(SmallSceneWith(
      3,
      "  geometry: {polygon: {points: [[0, 0], [80 mm, 0], [40 mm, 40 mm]], thickness: 9 mm, "
      "holes: [[[35 mm, 5 mm], [45 mm, 5 mm], [40 mm, 10 mm]]]}}"));
  const Outline outline = OutlineOf(polygon.object.geometry);
  EXPECT_EQ(outline.outer.size(), 3U);
  ASSERT_EQ(outline.holes.size(), 1U);
  EXPECT_EQ(outline.holes[0][2], Eigen::Vector2d(0.04, 0.01));

  const Scratch folder;
  folder.Write("outline.csv", ",Y (mm),X\n0,0,0\n1,0,0.08\n\n2,40,0.04\r\n");
  const auto file = folder.Write(
      "scene.yaml", SmallSceneWith(3, "  geometry: {contour: outline.csv, thickness: 9 mm}"));
  const Scene contour = LoadScene(file);
  EXPECT_EQ(OutlineOf(contour.object.geometry).outer, outline.outer);
  EXPECT_DOUBLE_EQ(ThicknessOf(contour.object.geometry), 9e-3);
}

// From 1 nm to 1 km and from 1 Pa to 1 TPa scenes are scenes.
TEST(SceneLoaderTest, AcceptsEverySizeAndStiffness) {
  for (const char* size : {"1 nm", "1 mm", "1 km"}) {
    for (const char* modulus : {"1 Pa", "1 TPa"}) {
      const std::string s(size);
      EXPECT_NO_THROW(
          Load(SmallScene(),
               {"object.geometry.rectangle.width=" + s, "object.geometry.rectangle.height=" + s,
                "object.geometry.rectangle.thickness=" + s, "tool.width=" + s,
                "object.material.young_modulus=" + std::string(modulus)}))
          << size << " " << modulus;
    }
  }
}

TEST(SceneLoaderTest, ARoundToolIsTwiceItsRadiusWideUnlessBothAreGiven) {
  const Scratch folder;
  const auto tool = [&](const std::string& line) {
    return LoadScene(folder.Write("scene.yaml", SmallSceneWith(7, line))).tool.value();
  };
  EXPECT_DOUBLE_EQ(tool("tool: {shape: round, radius: 3 mm}").width, 6e-3);
  EXPECT_DOUBLE_EQ(tool("tool: {shape: round, width: 4 mm}").radius, 2e-3);
  const Tool both = tool("tool: {shape: round, width: 4 mm, radius: 9 mm}");
  EXPECT_DOUBLE_EQ(both.width, 4e-3);
  EXPECT_DOUBLE_EQ(both.radius, 9e-3);
  EXPECT_EQ(tool("tool: {shape: flat, width: 4 mm}").radius, 0);
}

}  // namespace
}  // namespace palpate
