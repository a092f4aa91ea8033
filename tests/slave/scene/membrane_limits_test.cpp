// What a membrane may be for the site that plays it, and for the models.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/scene/stereo_scene.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// The accepted numbers are those of PressedMembrane for 39 mm by 1 mm: a / 50 or t to a for tools,
// a / 400 to a / 10 thick, E t / 2 of tension, a / 2 deep, three quarters of a from the centre.
TEST_F(StereoSceneTest, WhatTheSimulatedMembraneCannotPlayIsRefusedWhereItIsWritten) {
  const auto with = [&](auto change) {
    Lines lines;
    change(lines);
    return MistakesOf(lines);
  };
  for (const char* width : {"0", "0.9 mm", "40 mm"}) {
    const std::string said =
        with([&](Lines& l) { l.tool = "{width: " + std::string(width) + "}"; });
    EXPECT_THAT(said, HasSubstr("scene.yaml:7: tool.width = " + std::string(width)));
    EXPECT_THAT(said, HasSubstr("1 mm to 39 mm (the thickness"));
  }
  for (const char* thickness : {"0.09 mm", "4 mm"}) {
    EXPECT_THAT(with([&](Lines& l) {
                  l.geometry =
                      "{membrane: {radius: 39 mm, thickness: " + std::string(thickness) + "}}";
                }),
                HasSubstr(":3: object.geometry.membrane.thickness = " + std::string(thickness) +
                          ": accepted is 0.0975 mm to 3.9 mm (radius / 400 to radius / 10)"));
  }
  EXPECT_THAT(with([](Lines& l) { l.model = "{kind: plate-large, prestress: 13.7 kN/m}"; }),
              HasSubstr("prestress"));
  EXPECT_THAT(with([](Lines& l) { l.model = "{kind: plate-large, prestress: 13700}"; }),
              HasSubstr(":6: model.prestress = 13700: accepted is 0 to 13600 N/m"));
  EXPECT_THAT(with([](Lines& l) { l.more = "operator: {press: {depth: 20 mm}}\n"; }),
              HasSubstr(":11: operator.press.depth = 20 mm: accepted is > 0 to 19.5 mm"));
  EXPECT_THAT(
      with([](Lines& l) { l.more = "manipulator: {home: [0, 30 mm, 5 mm]}\n"; }),
      HasSubstr(":11: manipulator.home = [0, 30 mm, 5 mm]: accepted is a position in front of"));
  EXPECT_THAT(with([](Lines& l) { l.more = "site: {misplacement: [30 mm, 0]}\n"; }),
              HasSubstr(":11: site.misplacement = "));
  EXPECT_THAT(with([](Lines& l) { l.more = "site: {blur: 21}\n"; }),
              HasSubstr(":11: site.blur = 21: accepted is 0 to 20 px"));
  EXPECT_THAT(with([](Lines& l) { l.camera = "{source: simulated, pair: {}, size: [640, 9000]}"; }),
              HasSubstr(":9: sense.camera.size = [640, 9000]: accepted is"));
}

TEST_F(StereoSceneTest, WhatTheSimulatedMembraneJustCanPlayIsAccepted) {
  Lines lines;
  lines.tool = "{width: 9.75 mm}";
  lines.geometry = "{membrane: {radius: 39 mm, thickness: 3.9 mm}}";
  lines.model = "{kind: plate-large, prestress: 53000}";
  lines.more =
      "operator: {press: {depth: 19.5 mm}}\nmanipulator: {home: [0, 29.25 mm, 5 mm]}\n"
      "site: {blur: 20}\n";
  EXPECT_EQ(MistakesOf(lines), "");
}

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
