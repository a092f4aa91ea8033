// What is refused in scenes of two cameras and of depth pictures, and with which words.
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

// One mistake each, reported as `scene.yaml:message`.
struct BadScene {
  const char* name;
  Lines lines;
  const char* message;
};

void PrintTo(const BadScene& bad, std::ostream* out) {
  *out << bad.message;
}

class BadStereoSceneTest : public StereoSceneTest,
                           public ::testing::WithParamInterface<BadScene> {};

TEST_P(BadStereoSceneTest, IsReportedOnceWithItsPlace) {
  const std::string mistakes = MistakesOf(GetParam().lines);
  EXPECT_THAT(mistakes, HasSubstr("scene.yaml:" + std::string(GetParam().message)));
  EXPECT_EQ(std::count(mistakes.begin(), mistakes.end(), '\n') + 1, 1) << mistakes;
}

Lines Camera(const std::string& camera) {
  Lines lines;
  lines.camera = camera;
  return lines;
}
Lines Points(const std::string& points) {
  Lines lines;
  lines.points = points;
  return lines;
}
Lines PointsInFiles(const std::string& points) {
  Lines lines = Points(points);
  lines.camera = kFiles;
  return lines;
}
Lines PointsInDepth(const std::string& points) {
  Lines lines = Points(points);
  lines.camera = "{depth: pairs, fx: 1, fy: 1, cx: 1, cy: 1, pose: {translation: [0, 0, -1]}}";
  return lines;
}
Lines Files(const std::string& left, const std::string& right, const std::string& rig) {
  return Camera("{stereo: {left: \"" + left + "\", right: \"" + right + "\"" +
                (rig.empty() ? "" : ", rig: " + rig) + "}, pose: {translation: [0, 0, -1]}}");
}
Lines Depth(const std::string& keys) {
  return Camera("{depth: pairs, " + keys + "}");
}
Lines More(const std::string& more) {
  Lines lines;
  lines.more = more;
  return lines;
}
Lines Model(const std::string& model) {
  Lines lines;
  lines.model = model;
  return lines;
}
Lines Volume(const std::string& camera, const std::string& points, const std::string& fixed) {
  Lines lines{camera, points, kBox, fixed, "{kind: fem}", {}};
  return lines;
}

const BadScene kCameras[] = {
    {"NoBaseline", Camera("{source: simulated, pair: {baseline: 0}}"),
     "9: sense.camera.pair.baseline = 0: accepted is a length in m mm um nm km, > 0"},
    {"NegativeBaseline", Camera("{source: simulated, pair: {baseline: -60 mm}}"),
     "9: sense.camera.pair.baseline = -60 mm: accepted is a length"},
    {"BaselineBeyondTheObject", Camera("{source: simulated, pair: {baseline: 1 m}}"),
     "9: sense.camera.pair.baseline = 1 m: accepted is less than 1.5 times the distance"},
    {"BackToTheMembrane",
     Camera("{source: simulated, pair: {}, pose: {translation: [0, 0, 250 mm]}}"),
     "9: sense.camera.pose = {translation: [0, 0, 250 mm]}: accepted is a pose with the object's "
     "origin in front of the camera"},
    {"DepthFromBehind",
     Camera("{depth: pairs, fx: 1, fy: 1, cx: 1, cy: 1, pose: {translation: [0, 0, 0]}}"),
     "9: sense.camera.pose = {translation: [0, 0, 0]}: accepted is a pose with the object's"},
    {"BaselineInPixels", Camera("{source: simulated, pair: {baseline: 60 px}}"),
     "9: sense.camera.pair.baseline = 60 px: accepted is a length"},
    {"NoFocal", Camera("{source: simulated, pair: {focal: 0 px}}"),
     "9: sense.camera.pair.focal = 0 px: accepted is a number of pixels in px, 1 to 1e6"},
    {"FocalInMillimetres", Camera("{source: simulated, pair: {focal: 8 mm}}"),
     "9: sense.camera.pair.focal = 8 mm: accepted is a number of pixels"},
    {"FocalIsNan", Camera("{source: simulated, pair: {focal: .nan}}"),
     "9: sense.camera.pair.focal = .nan: accepted is a number of pixels"},
    {"PairIsNumber", Camera("{source: simulated, pair: 2}"),
     "9: sense.camera.pair = 2: accepted is a map"},
    {"UnknownOfPair", Camera("{source: simulated, pair: {base: 60 mm}}"),
     "9: sense.camera.pair.base = 60 mm: accepted is one of focal, baseline"},
    {"PairWithoutSource", Camera("{pair: {}}"),
     "9: sense.camera.source = (missing): accepted is exactly one of `source: simulated`"},
    {"SourceIsWord", Camera("{source: real, pair: {}}"),
     "9: sense.camera.source = real: accepted is simulated"},
    {"PairBesideFile", Camera("{file: pairs, pair: {}}"),
     "9: sense.camera.pair = {}: accepted is nothing with `file`"},
    {"PairBesideStereo",
     Camera("{stereo: {left: pairs, right: pairs, rig: rig.yaml}, pair: {}, pose: {translation: "
            "[0, 0, 0]}}"),
     "9: sense.camera.pair = {}: accepted is nothing with `stereo`"},
    {"TwoSources", Camera("{source: simulated, stereo: {}, rate: 30 Hz, pixel: 1 mm}"),
     "9: sense.camera.source = simulated: accepted is exactly one of"},
    {"StereoAndDepth", Camera("{stereo: {}, depth: pairs, fx: 1}"),
     "9: sense.camera.stereo = {}: accepted is exactly one of"},
    {"PixelOfAPair", Camera("{source: simulated, pair: {}, pixel: 0.3 mm}"),
     "9: sense.camera.pixel = 0.3 mm: accepted is nothing here"},
    {"RateZero", Camera("{source: simulated, pair: {}, rate: 0 Hz}"),
     "9: sense.camera.rate = 0 Hz: accepted is a frequency"},
    {"SizeOfOne", Camera("{source: simulated, pair: {}, size: [640]}"),
     "9: sense.camera.size = [640]: accepted is a list of 2 numbers"},
    {"SizeOfFiles",
     Camera("{stereo: {left: pairs, right: pairs, rig: rig.yaml}, size: [640, 480], pose: "
            "{translation: [0, 0, 0]}}"),
     "9: sense.camera.size = [640, 480]: accepted is"},
    {"NoLeft", Camera("{stereo: {right: pairs, rig: rig.yaml}, pose: {translation: [0, 0, -1]}}"),
     "9: sense.camera.stereo.left = (missing): accepted is a printf pattern"},
    {"EmptyGlob", Files("pairs/none*.png", "pairs", "rig.yaml"),
     "9: sense.camera.stereo.left = pairs/none*.png: accepted is a pattern that matches a file"},
    {"EmptyPattern", Files("pairs", "empty/%04d.png", "rig.yaml"),
     "9: sense.camera.stereo.right = empty/%04d.png: accepted is a pattern that matches a file"},
    {"NoSuchFolder", Files("nowhere/*.png", "pairs", "rig.yaml"),
     "9: sense.camera.stereo.left = nowhere/*.png: accepted is a pattern that matches a file"},
    {"EvilPattern", Files("pairs/%s%n.png", "pairs", "rig.yaml"),
     "9: sense.camera.stereo.left = pairs/%s%n.png: accepted is one number such as %d"},
    {"FolderAsPattern", Files("pairs%d/left.png", "pairs", "rig.yaml"),
     "9: sense.camera.stereo.left = pairs%d/left.png: accepted is one number such as %d"},
    {"NoRig", Files("pairs", "pairs", ""),
     "9: sense.camera.stereo.rig = (missing): accepted is a file that `calibrate` wrote"},
    {"RigMissing", Files("pairs", "pairs", "none.yaml"),
     "9: sense.camera.stereo.rig = none.yaml: accepted is a file that exists"},
    {"RigOfOneCamera", Files("pairs", "pairs", "left.yaml"),
     "9: sense.camera.stereo.rig = left.yaml: accepted is a rig of two cameras, written by "
     "`calibrate --left ... --right ...`; this one has no `right`"},
    {"RigOfTheOther", Files("pairs", "pairs", "right.yaml"),
     "9: sense.camera.stereo.rig = right.yaml: accepted is a rig of two cameras"},
    {"RigIsNoYaml", Files("pairs", "pairs", "broken.yaml"),
     "9: sense.camera.stereo.rig = broken.yaml: accepted is a rig of two cameras"},
    {"RigIsFolder", Files("pairs", "pairs", "pairs"),
     "9: sense.camera.stereo.rig = pairs: accepted is a file that exists"},
    {"NoPose", Camera("{stereo: {left: pairs, right: pairs, rig: rig.yaml}}"),
     "9: sense.camera.pose = (missing): accepted is a map of translation, rotation"},
    {"DepthWithoutPose", Depth("fx: 600, fy: 600, cx: 320, cy: 240"),
     "9: sense.camera.pose = (missing): accepted is a map of translation, rotation"},
    {"DepthWithoutFocal", Depth("fy: 600, cx: 320, cy: 240, pose: {translation: [0, 0, -1]}"),
     "9: sense.camera.fx = (missing): accepted is a number of pixels in px, 1 to 1e6"},
    {"UnitZero",
     Depth("unit: 0 mm, fx: 1, fy: 600, cx: 320, cy: 240, pose: {translation: [0, 0, -1]}"),
     "9: sense.camera.unit = 0 mm: accepted is a length"},
    {"UnitInPixels",
     Depth("unit: 1 px, fx: 1, fy: 600, cx: 320, cy: 240, pose: {translation: [0, 0, -1]}"),
     "9: sense.camera.unit = 1 px: accepted is a length"},
    {"SigmaOfDepthZero",
     Depth("sigma: 0, fx: 1, fy: 600, cx: 320, cy: 240, pose: {translation: [0, 0, -1]}"),
     "9: sense.camera.sigma = 0: accepted is a length"},
    {"CentreIsNan", Depth("fx: 1, fy: 600, cx: .nan, cy: 240, pose: {translation: [0, 0, -1]}"),
     "9: sense.camera.cx = .nan: accepted is a number of pixels"},
    {"NoDepth",
     Camera("{depth: none.png, fx: 1, fy: 1, cx: 1, cy: 1, pose: {translation: [0, 0, -1]}}"),
     "9: sense.camera.depth = none.png: accepted is a file that exists"},
};
INSTANTIATE_TEST_SUITE_P(Cameras, BadStereoSceneTest, ::testing::ValuesIn(kCameras),
                         [](const auto& row) { return std::string(row.param.name); });

const BadScene kPoints[] = {
    {"NoDots", Points("{count: 0}"),
     "10: sense.points.count = 0: accepted is a whole number from 4 to 400"},
    {"OneDot", Points("{count: 1}"), "10: sense.points.count = 1: accepted is a whole number"},
    {"TwoDots", Points("{count: 2}"), "10: sense.points.count = 2: accepted is a whole number"},
    {"DotsOnALine", Points("{count: 3}"), "10: sense.points.count = 3: accepted is a whole number"},
    {"AMillionDots", Points("{count: 1000000}"),
     "10: sense.points.count = 1000000: accepted is a whole number from 4 to 400"},
    {"HalfADot", Points("{count: 31.5}"), "10: sense.points.count = 31.5: accepted is a whole"},
    {"NegativeRadius", Points("{radius: -2 mm}"),
     "10: sense.points.radius = -2 mm: accepted is a length"},
    {"RadiusInPixels", Points("{radius: 2 px}"), "10: sense.points.radius = 2 px: accepted is"},
    {"DotsTouch", Points("{radius: 5 mm}"),
     "10: sense.points.radius = 5 mm: accepted is dots that do not touch each other"},
    {"SpacingBelowTheDots", Points("{spacing: [15 mm, 3 mm], radius: 2 mm}"),
     "10: sense.points.radius = 2 mm: accepted is dots that do not touch"},
    {"SpacingOfOne", Points("{spacing: [15 mm]}"),
     "10: sense.points.spacing = [15 mm]: accepted is a list of 2 numbers"},
    {"SpacingZero", Points("{spacing: [15 mm, 0]}"),
     "10: sense.points.spacing.1 = 0: accepted is a length"},
    {"SpacingOfAThread", Points("{spacing: [15 mm, 10 um]}"),
     "10: sense.points.spacing = [15 mm, 10 um]: accepted is two lengths"},
    {"TooWide", Points("{spacing: [17 mm, 12 mm]}"),
     "10: sense.points.spacing = [17 mm, 12 mm]: accepted is dots that all fit inside the "
     "membrane's rim"},
    {"NoSuchTrack", Points("{track: stripes}"),
     "10: sense.points.track = stripes: accepted is dots or texture or surface"},
    {"SurfaceOfAPair", Points("{track: surface}"),
     "10: sense.points.track = surface: accepted is dots or texture with a stereo pair"},
    {"DotsOfASimulatedTarget", Volume(kPair, "{track: dots, layout: dots.csv}", ""),
     "10: sense.points.track = dots: accepted is texture: a simulated pair shows dots on a "
     "membrane"},
    {"DotsInDepth", PointsInDepth("{track: dots}"),
     "10: sense.points.track = dots: accepted is surface with depth images"},
    {"WindowOfDots", Points("{window: 31 px}"), "10: sense.points.window = 31 px: accepted is"},
    {"UnknownKey", Points("{cuont: 31}"),
     "10: sense.points.cuont = 31: accepted is `count` (nearest)"},
    {"PointsAreAList", Points("[dots]"), "10: sense.points = [dots]: accepted is a map"},
    {"SigmaZero", Points("{sigma: 0 px}"),
     "10: sense.points.sigma = 0 px: accepted is a number of pixels in px, > 0"},
    {"SigmaIsNan", Points("{sigma: .nan}"), "10: sense.points.sigma = .nan: accepted is"},
    {"NoLayout", Points("{layout: none.csv}"),
     "10: sense.points.layout = none.csv: accepted is a file that exists"},
    {"LayoutOfWords", Points("{layout: words.csv}"),
     "10: sense.points.layout = words.csv: accepted is a CSV file of positions x,y [m]; "},
    {"LayoutAndCount", Points("{layout: dots.csv, count: 4}"),
     "10: sense.points.count = 4: accepted is nothing with `layout`"},
    {"LayoutBeyondTheRim", Points("{layout: wide.csv}"),
     "10: sense.points.layout = wide.csv: accepted is dots that all fit inside"},
    {"LayoutTooClose", Points("{layout: close.csv, radius: 1 mm}"),
     "10: sense.points.radius = 1 mm: accepted is dots that do not touch"},
    {"EvenWindow", PointsInFiles("{track: texture, window: 30 px}"),
     "10: sense.points.window = 30 px: accepted is an odd number of pixels"},
    {"SmallWindow", PointsInFiles("{track: texture, window: 7}"),
     "10: sense.points.window = 7: accepted is a whole number from 9 to 255"},
    {"NoWindows", PointsInFiles("{track: texture, count: 0}"),
     "10: sense.points.count = 0: accepted is a whole number from 1 to 10000"},
    {"AtNowhere", PointsInFiles("{track: texture, at: []}"),
     "10: sense.points.at = []: accepted is 1 to 10000 positions"},
    {"AtOutside", PointsInFiles("{track: texture, at: [[300, 200], [640, 100]]}"),
     "10: sense.points.at = [[300, 200], [640, 100]]: accepted is positions whose windows lie "
     "inside the image of 640 x 480 px"},
    {"AtTheEdge", PointsInFiles("{track: texture, at: [[14, 100]]}"),
     "10: sense.points.at = [[14, 100]]: accepted is positions whose windows lie inside"},
    {"AtInMillimetres", PointsInFiles("{track: texture, at: [[1 mm, 100]]}"),
     "10: sense.points.at.0.0 = 1 mm: accepted is a number of pixels"},
    {"AtAndCount", PointsInFiles("{track: texture, at: [[100, 100]], count: 1}"),
     "10: sense.points.count = 1: accepted is nothing with `at`"},
    {"SpacingOfTexture", PointsInFiles("{track: texture, spacing: [1 mm, 1 mm]}"),
     "10: sense.points.spacing = [1 mm, 1 mm]: accepted is"},
};
INSTANTIATE_TEST_SUITE_P(Points, BadStereoSceneTest, ::testing::ValuesIn(kPoints),
                         [](const auto& row) { return std::string(row.param.name); });

const BadScene kRest[] = {
    {"TipBesideAPair", More("  tip: {track: template}\n"),
     "11: sense.tip = {track: template}: accepted is nothing with a stereo pair or depth camera"},
    {"ContourBesideAPair", More("  contour: {track: snake}\n"),
     "11: sense.contour = {track: snake}: accepted is nothing with"},
    {"HomeInside", More("manipulator: {home: [0, 0, -5 mm]}\n"),
     "11: manipulator.home = [0, 0, -5 mm]: accepted is a position in front of the membrane"},
    {"NegativeTension", Model("{kind: plate-large, prestress: -1 N/m}"),
     "6: model.prestress = -1 N/m: accepted is a tension in N/m mN/m N/mm, >= 0"},
    {"TensionIsAPressure", Model("{kind: plate-large, prestress: 12 Pa}"),
     "6: model.prestress = 12 Pa: accepted is a tension"},
    {"TensionOfAPlate", Model("{kind: plate, prestress: 12 N/m}"),
     "6: model.prestress = 12 N/m: accepted is nothing with this kind: use plate-large"},
    {"TensionOfABox",
     {"{stereo: {left: pairs, right: pairs, rig: rig.yaml}, pose: {translation: [0, 0, -1]}}",
      "{}",
      kBox,
      "{plane: {axis: z, at: 0 m}}",
      "{prestress: 1}",
      {}},
     "6: model.prestress = 1: accepted is nothing here: only a membrane"},
    {"PlaneSeenByTwo",
     {kPair,
      "{track: texture}",
      "{rectangle: {width: 1, height: 1, thickness: 1 mm}}",
      "{side: bottom}",
      "{kind: bem2d}",
      {}},
     "3: object.geometry = "},
    {"PaceIsSpeed", More("site: {pace: 3 m/s}\n"), "11: site.pace = 3 m/s: accepted is a number"},
    {"HeldTarget", Volume(kPair, "{}", "{plane: {axis: z, at: 0 m}}"),
     "5: object.fixed = {plane: {axis: z, at: 0 m}}: accepted is nothing with a simulated textured "
     "target"},
    {"DotsOfABox", Volume(kFiles, "{track: dots}", "{plane: {axis: z, at: 0 m}}"),
     "10: sense.points.track = dots: accepted is texture, or dots with a `layout`"},
    {"DepthOfWhatIsNotHeld",
     Volume("{depth: pairs, fx: 1, fy: 1, cx: 1, cy: 1, pose: {translation: [0, 0, -1]}}", "{}",
            ""),
     "2: object.fixed = (missing): accepted is the fixed part of the object"},
};
INSTANTIATE_TEST_SUITE_P(Rest, BadStereoSceneTest, ::testing::ValuesIn(kRest),
                         [](const auto& row) { return std::string(row.param.name); });

// Cut short or changed at any third byte: whatever happens, it is a SceneError or a scene.
TEST_F(StereoSceneTest, NoBrokenTextCrashes) {
  Lines lines;
  lines.camera = kFiles;
  lines.points = "{track: texture, at: [[100, 100], [200, 120]], window: 31 px, sigma: 0.3 px}";
  const std::string text = StereoScene(lines);
  const std::string bytes = "\xff\x01:[]{}&*!|>%@`'\"#,-?\n\t~9";
  int refused = 0;
  const auto load = [&](const std::string& broken) {
    try {
      LoadScene(folder_.Write("scene.yaml", broken));
    } catch (const SceneError&) {
      ++refused;
    }
  };
  for (std::size_t i = 0; i < text.size(); i += 3) {
    load(text.substr(0, i));
    std::string changed = text;
    changed[i] = bytes[i % bytes.size()];
    load(changed);
  }
  EXPECT_GT(refused, static_cast<int>(text.size()) / 3);
}

TEST_F(StereoSceneTest, PointsBesideFingertipsAreRefused) {
  const std::string text = "name: touch\nobject:\n  geometry: " + std::string(kBox) +
                           "\n  material: {young_modulus: 3.8 kPa, poisson_ratio: 0.15}\n"
                           "  fixed: {plane: {axis: z, at: 0 m}}\nmodel: {kind: fem}\n"
                           "sense: {tactile: {source: stream}, points: {track: dots}}\n";
  EXPECT_THAT(Thrown<SceneError>([&] { LoadScene(folder_.Write("scene.yaml", text)); }),
              HasSubstr(":7: sense.points = {track: dots}: accepted is nothing with `tactile`"));
}

// One camera tells of planar objects only; the sentence says what else there is.
TEST_F(StereoSceneTest, AMembraneBeforeOneCameraIsToldOfTwo) {
  const std::string mistakes = MistakesOf(Camera("{source: simulated, pixel: 0.3 mm}"));
  EXPECT_THAT(mistakes, HasSubstr(":3: object.geometry = "));
  EXPECT_THAT(mistakes, HasSubstr("camera: {source: simulated, pair: {}}"));
  EXPECT_THAT(mistakes, HasSubstr("camera: {stereo: {left, right, rig}}"));
}

}  // namespace
}  // namespace palpate
