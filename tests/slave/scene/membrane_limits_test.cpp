// What a membrane may be for the site that plays it, and for the models.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/scene/stereo_scene.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// Real membranes are as their owner says, as far as plates have an answer.
TEST_F(StereoSceneTest, ARealMembraneHasTheLimitsOfItsModels) {
  Lines lines;
  lines.camera = kFiles;
  lines.tool = "{width: 60 mm}";
  lines.more = "manipulator: {home: [0, 38 mm, 5 mm]}\n";
  EXPECT_EQ(MistakesOf(lines), "");
  lines.tool = "{width: 71 mm}";
  EXPECT_THAT(MistakesOf(lines), HasSubstr(":7: tool.width = 71 mm: accepted is a length"));
  lines.tool = "{width: 4 mm}";
  lines.geometry = "{membrane: {radius: 39 mm, thickness: 4 mm}}";
  EXPECT_THAT(MistakesOf(lines),
              HasSubstr(":3: object.geometry.membrane.thickness = 4 mm: accepted is > 0 to 3.9"));
  EXPECT_THAT(MistakesOf(lines, SceneUse::kSolve), HasSubstr("accepted is > 0 to 3.9"));
}

}  // namespace
}  // namespace palpate
