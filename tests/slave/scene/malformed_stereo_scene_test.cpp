// Tests mistakes in scenes with two cameras or depth images, and their messages.
#include <algorithm>
#include <ostream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/scene/stereo_scene.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// One mistake: its text and position, and the accepted values in the message.
struct BadScene {
  SceneLines lines;
  std::string message;

  friend std::ostream& operator<<(std::ostream& out, const BadScene& bad) {
    return out << bad.message;
  }
};

class BadStereoSceneTest : public StereoSceneTest,
                           public ::testing::WithParamInterface<BadScene> {};

TEST_P(BadStereoSceneTest, IsReportedOnceWithItsPlace) {
  const std::string mistakes = MistakesOf(GetParam().lines);
  EXPECT_THAT(mistakes, HasSubstr("scene.yaml:" + GetParam().message));
  EXPECT_EQ(std::count(mistakes.begin(), mistakes.end(), '\n') + 1, 1) << mistakes;
}

using Words = const std::string&;

BadScene Row(const SceneLines& lines, Words mistake, Words accepted) {
  return {lines, mistake + ": expected " + accepted};
}

BadScene BadCamera(Words camera, Words mistake, Words accepted) {
  return Row({"{" + camera + "}"}, "9: sense.camera." + mistake, accepted);
}
BadScene BadPair(Words pair, Words mistake, Words accepted) {
  return BadCamera("source: simulated, pair: {" + pair + "}", mistake, accepted);
}
BadScene Posed(Words camera, Words mistake, Words accepted) {
  return BadCamera(camera + ", pose: {translation: [0, 0, -1]}", mistake, accepted);
}
BadScene Left(Words left, Words accepted) {
  return Posed("stereo: {left: \"" + left + "\", right: pairs, rig: rig.yaml}",
               "stereo.left = " + left, accepted);
}
BadScene Rig(Words rig, Words accepted) {
  return Posed("stereo: {left: pairs, right: pairs, rig: " + rig + "}", "stereo.rig = " + rig,
               accepted);
}

BadScene Points(Words points, Words mistake, Words accepted) {
  return Row({kPair, "{" + points + "}"}, "10: sense.points." + mistake, accepted);
}
BadScene InFiles(Words points, Words mistake, Words accepted) {
  return Row({kFiles, "{" + points + "}"}, "10: sense.points." + mistake, accepted);
}

BadScene More(Words more, Words mistake, Words accepted) {
  return Row({.more = more + "\n"}, "11: " + mistake, accepted);
}
BadScene Model(Words model, Words mistake, Words accepted) {
  return Row({.model = "{" + model + "}"}, "6: model." + mistake, accepted);
}
SceneLines Volume(Words camera, Words points, Words fixed) {
  return {camera, points, kBox, fixed, "{kind: fem}"};
}
constexpr const char* kHeld = "{plane: {axis: z, at: 0 m}}";
constexpr const char* kPlate = "{rectangle: {width: 1, height: 1, thickness: 1 mm}}";
constexpr const char* kDepth =
    "{depth: pairs, fx: 1, fy: 1, cx: 1, cy: 1, pose: {translation: [0, 0, -1]}}";

const BadScene kCameras[] = {
    BadPair("baseline: 1 m", "pair.baseline = 1 m", "less than 1.5 times the distance"),
    BadCamera("source: simulated, pair: {}, pose: {translation: [0, 0, 250 mm]}",
              "pose = {translation: [0, 0, 250 mm]}",
              "a pose with the object's origin in front of the camera"),
    BadCamera("depth: pairs, fx: 1, fy: 1, cx: 1, cy: 1, pose: {translation: [0, 0, 0]}",
              "pose = {translation: [0, 0, 0]}", "a pose with the object's"),
    BadCamera("pair: {}", "source = (missing)", "exactly one of `source: simulated`"),
    BadCamera("file: pairs, pair: {}", "pair = {}", "nothing with `file`"),
    BadCamera("source: simulated, stereo: {}, rate: 30 Hz, pixel: 1 mm", "source = simulated",
              "exactly one of"),
    Posed("size: [640, 480], stereo: {left: pairs, right: pairs, rig: rig.yaml}",
          "size = [640, 480]", ""),
    Left("pairs/none*.png", "a pattern that matches a file"),
    Posed("stereo: {left: pairs, right: empty/%04d.png, rig: rig.yaml}",
          "stereo.right = empty/%04d.png", "a pattern that matches a file"),
    Posed("stereo: {left: pairs, right: pairs}", "stereo.rig = (missing)",
          "a file that `calibrate` wrote"),
    Rig("left.yaml",
        "a rig of two cameras, written by `calibrate --left ... --right ...`; this one has no "
        "`right`"),
    BadCamera("depth: pairs, fx: 600, fy: 600, cx: 320, cy: 240", "pose = (missing)",
              "a map of translation, rotation"),
};
INSTANTIATE_TEST_SUITE_P(Cameras, BadStereoSceneTest, ::testing::ValuesIn(kCameras));

const BadScene kPoints[] = {
    Points("radius: 5 mm", "radius = 5 mm", "dots that do not touch each other"),
    Points("spacing: [15 mm, 10 um]", "spacing = [15 mm, 10 um]", "two lengths"),
    Points("spacing: [17 mm, 12 mm]", "spacing = [17 mm, 12 mm]",
           "dots that all fit inside the membrane's rim"),
    Points("track: surface", "track = surface", "dots or texture with a stereo pair"),
    Row(Volume(kPair, "{track: dots, layout: dots.csv}", ""), "10: sense.points.track = dots",
        "texture: a simulated pair shows dots on a membrane"),
    Row({kDepth, "{track: dots}"}, "10: sense.points.track = dots", "surface with depth images"),
    Points("layout: words.csv", "layout = words.csv", "a CSV file of positions x,y [m];"),
    Points("layout: dots.csv, count: 4", "count = 4", "nothing with `layout`"),
    Points("layout: wide.csv", "layout = wide.csv", "dots that all fit inside"),
    InFiles("track: texture, window: 30 px", "window = 30 px", "an odd number of pixels"),
    InFiles("track: texture, at: []", "at = []", "1 to 10000 positions"),
    InFiles("track: texture, at: [[300, 200], [640, 100]]", "at = [[300, 200], [640, 100]]",
            "positions whose windows lie inside the image of 640 x 480 px"),
    InFiles("track: texture, at: [[100, 100]], count: 1", "count = 1", "nothing with `at`"),
};
INSTANTIATE_TEST_SUITE_P(Points, BadStereoSceneTest, ::testing::ValuesIn(kPoints));

const BadScene kRest[] = {
    More("  tip: {track: template}", "sense.tip = {track: template}",
         "nothing with a stereo pair or depth camera"),
    More("manipulator: {home: [0, 0, -5 mm]}", "manipulator.home = [0, 0, -5 mm]",
         "a position in front of the membrane"),
    Model("kind: plate, prestress: 12 N/m", "prestress = 12 N/m",
          "nothing with this kind: use plate-large"),
    Row({kFiles, "{}", kBox, kHeld, "{prestress: 1}"}, "6: model.prestress = 1",
        "nothing here: only a membrane"),
    Row({kPair, "{track: texture}", kPlate, "{side: bottom}", "{kind: bem2d}"},
        "3: object.geometry = " + std::string(kPlate), ""),
    Row(Volume(kPair, "{}", kHeld), "5: object.fixed = {plane: {axis: z, at: 0 m}}",
        "nothing with a simulated textured target"),
    Row(Volume(kFiles, "{track: dots}", kHeld), "10: sense.points.track = dots",
        "texture, or dots with a `layout`"),
    Row(Volume(kDepth, "{}", ""), "2: object.fixed = (missing)", "the fixed part of the object"),
};
INSTANTIATE_TEST_SUITE_P(Rest, BadStereoSceneTest, ::testing::ValuesIn(kRest));

}  // namespace
}  // namespace palpate
