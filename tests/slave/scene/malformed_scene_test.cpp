// Every mistake in a scene is answered by a sentence that says where it is and what is accepted.
#include <algorithm>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/slave/scene/scene_file.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// What LoadScene complains about; empty: nothing.
std::string MistakesOf(const std::filesystem::path& file,
                       const std::vector<std::string>& overrides = {},
                       SceneUse use = SceneUse::kFull) {
  try {
    LoadScene(file, overrides, use);
    return {};
  } catch (const SceneError& error) {
    return error.what();
  }
}

int LineCount(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n')) + (text.empty() ? 0 : 1);
}

// SmallScene with one line replaced: exactly one mistake, reported as `scene.yaml:message`.
struct BadLine {
  const char* name;
  int line;
  const char* replacement;
  const char* message;
};

class BadLineTest : public ::testing::TestWithParam<BadLine> {};

TEST_P(BadLineTest, IsReportedOnceWithItsPlace) {
  const SceneFolder folder;
  const auto file =
      folder.Write("scene.yaml", SmallSceneWith(GetParam().line, GetParam().replacement));
  const std::string mistakes = MistakesOf(file);
  EXPECT_THAT(mistakes, HasSubstr(file.string() + ":" + GetParam().message));
  EXPECT_EQ(LineCount(mistakes), 1) << mistakes;
}

const BadLine kObjectLines[] = {
    {"NoName", 1, "# none", "2: name = (missing): accepted is a name"},
    {"NameIsList", 1, "name: [a]", "1: name = [a]: accepted is a name"},
    {"NameEmpty", 1, "name:", "1: name = (nothing): accepted is a name"},
    {"WrongDimension", 3,
     "  geometry: {rectangle: {width: 80 kPa, height: 40 mm, thickness: 9 mm}}",
     "3: object.geometry.rectangle.width = 80 kPa: accepted is a length in m mm um nm km, > 0"},
    {"Negative", 3, "  geometry: {rectangle: {width: -80 mm, height: 40 mm, thickness: 9 mm}}",
     "3: object.geometry.rectangle.width = -80 mm: accepted is a length"},
    {"Zero", 3, "  geometry: {rectangle: {width: 80 mm, height: 40 mm, thickness: 0}}",
     "3: object.geometry.rectangle.thickness = 0: accepted is a length"},
    {"NotANumber", 3, "  geometry: {rectangle: {width: .nan, height: 40 mm, thickness: 9 mm}}",
     "3: object.geometry.rectangle.width = .nan: accepted is a length"},
    {"Infinite", 3, "  geometry: {rectangle: {width: inf, height: 40 mm, thickness: 9 mm}}",
     "3: object.geometry.rectangle.width = inf: accepted is a length"},
    {"TooLarge", 3, "  geometry: {rectangle: {width: 1e300, height: 40 mm, thickness: 9 mm}}",
     "3: object.geometry.rectangle.width = 1e300: accepted is a length"},
    {"SizeIsMap", 3, "  geometry: {rectangle: {width: {a: b}, height: 40 mm, thickness: 9 mm}}",
     "3: object.geometry.rectangle.width = {a: b}: accepted is a length"},
    {"SizeMissing", 3, "  geometry: {rectangle: {height: 40 mm, thickness: 9 mm}}",
     "3: object.geometry.rectangle.width = (missing): accepted is a length"},
    {"TwoGeometries", 3,
     "  geometry: {rectangle: {width: 8 cm, height: 1}, disc: {radius: 1 mm, thickness: 1 mm}}",
     "3: object.geometry = "},
    {"NoGeometry", 3, "  geometry: {}",
     "3: object.geometry = {}: accepted is exactly one of rectangle, disc, polygon, contour"},
    {"UnknownGeometry", 3, "  geometry: {disk: {radius: 1 mm, thickness: 1 mm}}",
     "3: object.geometry.disk = {radius: 1 mm, thickness: 1 mm}: accepted is `disc` (nearest)"},
    {"CrossingPolygon", 3,
     "  geometry: {polygon: {points: [[0, 0], [2, 2], [2, 0], [0, 1]], thickness: 9 mm}}",
     "3: object.geometry.polygon.points = [[0, 0], [2, 2], [2, 0], [0, 1]]: accepted is a simple "
     "polygon with holes inside; outer loop: edges 0 and 2 cross or touch"},
    {"PointOfThree", 3,
     "  geometry: {polygon: {points: [[0, 0], [2, 2, 2], [2, 0]], thickness: 9 mm}}",
     "3: object.geometry.polygon.points.1 = [2, 2, 2]: accepted is a list of 2 numbers"},
    {"PointsAreText", 3, "  geometry: {polygon: {points: many, thickness: 9 mm}}",
     "3: object.geometry.polygon.points = many: accepted is a list"},
    {"NoContourFile", 3, "  geometry: {contour: missing.csv, thickness: 9 mm}",
     "3: object.geometry.contour = missing.csv: accepted is from-image, or a CSV file of x,y"},
    {"PoissonTooLarge", 4, "  material: {young_modulus: 127 kPa, poisson_ratio: 0.51}",
     "4: object.material.poisson_ratio = 0.51: accepted is a number, plain or %, -1 < nu <= 0.5"},
    {"PoissonMinusOne", 4, "  material: {young_modulus: 127 kPa, poisson_ratio: -1}",
     "4: object.material.poisson_ratio = -1: accepted is"},
    {"NoModulus", 4, "  material: {poisson_ratio: 0.4}",
     "4: object.material.young_modulus = (missing): accepted is a pressure in Pa kPa MPa GPa TPa"},
    {"UnknownKey", 4, "  material: {young_modulus: 127 kPa, poison_ratio: 0.4, poisson_ratio: 0.4}",
     "4: object.material.poison_ratio = 0.4: accepted is `poisson_ratio` (nearest) or another of "
     "young_modulus"},
    {"MaterialIsText", 4, "  material: rubber",
     "4: object.material = rubber: accepted is a map of `key: value`"},
    {"Twice", 4, "  material: {young_modulus: 1, poisson_ratio: 0.4, young_modulus: 2}",
     "4: object.material.young_modulus = 2: accepted is each key once: it is already in line 4"},
    {"NoSuchSide", 5, "  fixed: {side: front}",
     "5: object.fixed.side = front: accepted is bottom, top, left, right or rim"},
    {"ArcOfRectangle", 5, "  fixed: {arc: {centre: 0 deg, half_angle: 10 deg}}",
     "5: object.fixed.arc = {centre: 0 deg, half_angle: 10 deg}: accepted is no arc with this "
     "geometry"},
    {"TwoPlaces", 5, "  fixed: {side: top, nodes: [1]}",
     "5: object.fixed = {side: top, nodes: [1]}: accepted is exactly one of side, arc, plane, "
     "nodes"},
    {"SecondOfList", 5, "  fixed: [{side: top}, {side: up}]",
     "5: object.fixed.1.side = up: accepted is"},
    {"NodeBeyond", 5, "  fixed: {nodes: [0, 180]}",
     "5: object.fixed = {nodes: [0, 180]}: accepted is nodes from 0 to 179"},
    {"NodeNegative", 5, "  fixed: {nodes: [-1]}",
     "5: object.fixed.nodes.0 = -1: accepted is a whole number"},
    {"NoNodes", 5, "  fixed: {nodes: []}",
     "5: object.fixed.nodes = []: accepted is a list of element"},
    {"PlaneWithoutAxis", 5, "  fixed: {plane: {at: 0 m}}",
     "5: object.fixed.plane.axis = (missing): accepted is x or y"},
    {"ComponentZ", 5, "  fixed: {side: bottom, components: z}",
     "5: object.fixed.components = z: accepted is x, y, xy or [x, y]"},
    {"NothingFixed", 5, "  pose: {}",
     "2: object.fixed = (missing): accepted is the fixed part of the object"},
    {"TiltedObject", 5, "  fixed: {side: bottom}\n  pose: {rotation: [90 deg, 0, 0]}",
     "6: object.pose.rotation = [90 deg, 0, 0]: accepted is [0, 0, angle]"},
    {"RaisedObject", 5, "  fixed: {side: bottom}\n  pose: {translation: [0, 0, 1 mm]}",
     "6: object.pose.translation = [0, 0, 1 mm]: accepted is [x, y, 0]"},
};
INSTANTIATE_TEST_SUITE_P(Object, BadLineTest, ::testing::ValuesIn(kObjectLines),
                         [](const auto& row) { return std::string(row.param.name); });

const BadLine kOtherLines[] = {
    {"ModelOfAVolume", 6, "model: {kind: fem}",
     "6: model.kind = fem: accepted is auto, bem2d or shell for a planar outline"},
    {"NoSuchOrder", 6, "model: {kind: bem2d, order: cubic}",
     "6: model.order = cubic: accepted is constant or linear or quadratic"},
    {"KeyOfAnotherKind", 6, "model: {kind: bem2d, step: 1 ms}", "6: model.step = 1 ms"},
    {"FewElements", 6, "model: {elements: 2}",
     "6: model.elements = 2: accepted is a whole number from 3 to 4000"},
    {"ThreeForARectangle", 6, "model: {elements: 3}",
     "6: model.elements = 3: accepted is 4 to 4000 for a rectangle"},
    {"ManyElements", 6, "model: {elements: 4001}", "6: model.elements = 4001: accepted is"},
    {"HalfElements", 6, "model: {elements: 60.5}",
     "6: model.elements = 60.5: accepted is a whole number"},
    {"ElementsAsPercent", 6, "model: {elements: 6000 %}",
     "6: model.elements = 6000 %: accepted is a whole"},
    {"NoSuchPlane", 6, "model: {plane: flat}",
     "6: model.plane = flat: accepted is stress or strain"},
    {"NoSuchContact", 6, "model: {contact: glued}",
     "6: model.contact = glued: accepted is bonded or frictionless"},
    {"RateIsTime", 6, "model: {rate: 2 ms}",
     "6: model.rate = 2 ms: accepted is a frequency in Hz kHz"},
    {"ModelIsList", 6, "model: [bem2d]", "6: model = [bem2d]: accepted is a map of `key: value`"},
    {"PunctureWithoutDepth", 6, "model: {puncture: {}}",
     "6: model.puncture.depth = (missing): accepted is a length"},
    {"ToolWithoutWidth", 7, "tool: {shape: flat}",
     "7: tool.width = (missing): accepted is a length"},
    {"NoSuchTool", 7, "tool: {shape: sharp, width: 1 mm}",
     "7: tool.shape = sharp: accepted is flat or round"},
    {"RadiusOfAFlatTool", 7, "tool: {width: 1 mm, radius: 1 mm}",
     "7: tool.radius = 1 mm: accepted is nothing with a flat tool"},
    {"RoundToolWiderThanItsEnd", 7, "tool: {shape: round, width: 5 mm, radius: 2 mm}",
     "7: tool.radius = 2 mm: accepted is at least half of tool.width"},
    {"RoundToolOfNoSize", 7, "tool: {shape: round}",
     "7: tool.width = (missing): accepted is a length"},
    {"PunctureFromNothing", 6, "model: {puncture: {from: 0 um}}",
     "6: model.puncture.from = 0 um: accepted is a length"},
    {"ShellOfARectangle", 6, "model: {kind: shell, wall: 2 um}",
     "6: model.kind = shell: accepted is bem2d, or shell for a disc fixed on an arc"},
    {"ShellWithoutWall", 6, "model: {kind: shell}",
     "6: model.wall = (missing): accepted is a length"},
    {"WallOfASolid", 6, "model: {kind: bem2d, wall: 2 um}", "6: model.wall = 2 um: accepted is"},
    {"NoDirection", 7, "tool: {width: 1 mm, direction: [0, 0]}",
     "7: tool.direction = [0, 0]: accepted is a direction"},
    {"NoPixel", 9, "  camera: {source: simulated}",
     "9: sense.camera.pixel = (missing): accepted is a length"},
    {"PixelInPixels", 9, "  camera: {source: simulated, pixel: 1 px}",
     "9: sense.camera.pixel = 1 px: accepted is a length"},
    {"TwoSources", 9, "  camera: {source: simulated, device: 0, pixel: 1 mm}",
     "9: sense.camera.source = simulated: accepted is exactly one of `source: simulated`, `file`, "
     "`device`, `stereo` and `depth`, or `url` or `source: stream`"},
    {"NoSource", 9, "  camera: {pixel: 1 mm}",
     "9: sense.camera.source = (missing): accepted is exactly one of"},
    {"SourceIsFile", 9, "  camera: {source: a.png, pixel: 1 mm}",
     "9: sense.camera.source = a.png: accepted is simulated"},
    {"NoSuchPicture", 9, "  camera: {file: none.png, pixel: 1 mm}",
     "9: sense.camera.file = none.png: accepted is a file that exists"},
    {"EvilPattern", 9, "  camera: {file: \"%s%n.png\", pixel: 1 mm}",
     "9: sense.camera.file = %s%n.png: accepted is one number such as %d or %04d"},
    {"NoMatchingPicture", 9, "  camera: {file: \"none*.png\", pixel: 1 mm}",
     "9: sense.camera.file = none*.png: accepted is a pattern that matches a file; none is"},
    {"NoNumberedPicture", 9, "  camera: {file: \"none%04d.png\", pixel: 1 mm}",
     "9: sense.camera.file = none%04d.png: accepted is a pattern that matches a file; none is"},
    {"NoLens", 9, "  camera: {source: simulated, pixel: 1 mm, intrinsics: a.yaml}",
     "9: sense.camera.intrinsics = a.yaml: accepted is a file that exists"},
    {"PointsOfOneCamera", 11, "  points: {track: dots}",
     "11: sense.points = {track: dots}: accepted is nothing with one camera"},
    {"SizeOfOne", 9, "  camera: {source: simulated, pixel: 1 mm, size: [640]}",
     "9: sense.camera.size = [640]: accepted is a list of 2 numbers, each a number of pixels in "
     "px"},
    {"SizeTooSmall", 9, "  camera: {source: simulated, pixel: 1 mm, size: [640, 1]}",
     "9: sense.camera.size.1 = 1: accepted is a number of pixels in px, 16 to"},
    {"RateZero", 9, "  camera: {source: simulated, pixel: 1 mm, rate: 0}",
     "9: sense.camera.rate = 0: accepted is a frequency"},
    {"LaterTip", 10, "  tip: {track: ssd}",
     "10: sense.tip.track = ssd: accepted is template in this version"},
    {"NoTemplate", 10, "  tip: {template: none.png}",
     "10: sense.tip.template = none.png: accepted is a file that exists"},
    {"ScoreAboveOne", 10, "  tip: {min_score: 2}",
     "10: sense.tip.min_score = 2: accepted is a number, plain or %, 0 to 1"},
    {"RoiInMillimetres", 10, "  tip: {roi: 64 mm}",
     "10: sense.tip.roi = 64 mm: accepted is a whole number from 8"},
    {"FewControlPoints", 11, "  contour: {control_points: 2}",
     "11: sense.contour.control_points = 2: accepted is"},
    {"NegativeWeight", 11, "  contour: {alpha: -1}", "11: sense.contour.alpha = -1: accepted is"},
    {"StartIsWord", 11, "  contour: {start: somewhere}",
     "11: sense.contour.start = somewhere: accepted is auto, {circle"},
    {"StartOfTwo", 11, "  contour: {start: {polygon: [[0, 0], [1, 1]]}}",
     "11: sense.contour.start.polygon = [[0, 0], [1, 1]]: accepted is three points"},
    {"NoForceLimit", 11, "  contour: {}\noperator: {force_limit: 0 N}",
     "12: operator.force_limit = 0 N: accepted is a force in N mN uN"},
    {"NoScale", 11, "  contour: {}\noperator: {position_scale: -1}",
     "12: operator.position_scale = -1: accepted is"},
    {"PressSpeedIsLength", 11, "  contour: {}\noperator: {press: {speed: 20 mm}}",
     "12: operator.press.speed = 20 mm: accepted is a speed in m/s"},
    {"ArmOfAnotherKind", 11, "  contour: {}\nmanipulator: {source: robot}",
     "12: manipulator.source = robot: accepted is simulated or stream or mp285"},
    {"PortOfNoLine", 11, "  contour: {}\nmanipulator: {port: /dev/ttyUSB0}",
     "12: manipulator.port = /dev/ttyUSB0: accepted is nothing with a simulated manipulator"},
    {"SilenceOfASimulatedArm", 11, "  contour: {}\nmanipulator: {silence: 50 ms}",
     "12: manipulator.silence = 50 ms: accepted is nothing here"},
    {"LongSilence", 11, "  contour: {}\nmanipulator: {source: stream, silence: 1 s}",
     "12: manipulator.silence = 1 s: accepted is a time"},
    {"LinkThatNeverDies", 11, "  contour: {}\nlink: {dead_after: 2 s}",
     "12: link.dead_after = 2 s: accepted is"},
    {"LinkThatDiesAtOnce", 11, "  contour: {}\nlink: {dead_after: 9 ms}",
     "12: link.dead_after = 9 ms: accepted is a time in s ms us, 10 to 500 ms"},
    {"HomeOutside", 11, "  contour: {}\nmanipulator: {home: [9 m, 0, 0]}",
     "12: manipulator.home = [9 m, 0, 0]: accepted is a position inside the manipulator's "
     "workspace"},
    {"HomeInside", 11, "  contour: {}\nmanipulator: {home: [40 mm, 20 mm, 0]}",
     "12: manipulator.home = [40 mm, 20 mm, 0]: accepted is a position outside the object"},
    {"WorkspaceTurned", 11,
     "  contour: {}\nmanipulator: {workspace: {min: [1, 0, 0], max: [0, 1, 0]}}",
     "12: manipulator.workspace.max = [0, 1, 0]: accepted is a corner with no coordinate below"},
    {"NoPace", 11, "  contour: {}\nsite: {pace: 0}",
     "12: site.pace = 0: accepted is a number, plain or %, 0.001 to 1000"},
    {"BlurInMetres", 11, "  contour: {}\nsite: {blur: 1 mm}",
     "12: site.blur = 1 mm: accepted is a number of pixels in px"},
    {"NegativeSeed", 11, "  contour: {}\nsite: {seed: -1}",
     "12: site.seed = -1: accepted is a whole number"},
    {"MotionWithoutPeriod", 11,
     "  contour: {}\nsite: {motion: {amplitude: [0 m, 1 mm], period: 0 s}}",
     "12: site.motion.period = 0 s: accepted is a time in s ms us, > 0"},
    {"EmbryoOfARectangle", 11, "  contour: {}\nsite: {embryo: {debris: 3}}",
     "12: site.embryo = {debris: 3}: accepted is a disc, or a contour from the image"},
    {"UnknownSection", 11, "  contour: {}\nsites: {}",
     "12: sites = {}: accepted is `site` (nearest) or another of name, object"},
    {"UnknownFarKey", 11, "  contour: {}\nzebra: {}",
     "12: zebra = {}: accepted is one of name, object"},
};
INSTANTIATE_TEST_SUITE_P(Rest, BadLineTest, ::testing::ValuesIn(kOtherLines),
                         [](const auto& row) { return std::string(row.param.name); });

// A whole file that is no scene: one mistake, containing the message.
struct BadFile {
  const char* name;
  std::string text;
  const char* message;
};

class BadFileTest : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadFileTest, IsRefusedWithItsReason) {
  const SceneFolder folder;
  const auto file = folder.Write("scene.yaml", GetParam().text);
  const std::string mistakes = MistakesOf(file);
  EXPECT_THAT(mistakes, ::testing::StartsWith(file.string() + ":"));
  EXPECT_THAT(mistakes, HasSubstr(GetParam().message));
  EXPECT_EQ(LineCount(mistakes), 1) << mistakes;
}

// Ten aliases of ten aliases ...: 10^8 values in 200 bytes.
std::string AliasBomb() {
  std::ostringstream text;
  text << "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 8; ++i) {
    text << "a" << i << ": &a" << i << " [*a" << i - 1;
    for (int k = 1; k < 10; ++k) text << ", *a" << i - 1;
    text << "]\n";
  }
  return text.str();
}

INSTANTIATE_TEST_SUITE_P(
    Files, BadFileTest,
    ::testing::Values(BadFile{"Empty", "", "empty: accepted is a map of name, object, model"},
                      BadFile{"OnlyComments", "# nothing\n", "empty: accepted is a map"},
                      BadFile{"List", "- a\n- b\n", "not a scene: accepted is a map"},
                      BadFile{"Word", "hello", "not a scene: accepted is a map"},
                      BadFile{"BrokenYaml", "name: a\nobject: {geometry: [\n", "not YAML"},
                      BadFile{"WrongIndent", "name: a\n  object: b: c\n", ":2: not YAML"},
                      BadFile{"TwoDocuments", "name: a\n---\nname: b\n", ":2: a second document"},
                      // The library makes documents of it without end.
                      BadFile{"CommaAlone", "name: a\n ,b: c\n", "not YAML"},
                      BadFile{"CommaFirst", " ,a: b", ":1: a second document"},
                      BadFile{"Binary", std::string("name: \0\1\2", 9), "not text"},
                      BadFile{"TooLarge", std::string((1 << 20) + 1, '#'), "at most 1 MiB"},
                      BadFile{"Deep", "name: " + std::string(100, '[') + std::string(100, ']'),
                              "at most 32 levels"},
                      BadFile{"VeryDeep", std::string(100000, '['), "not YAML"},
                      BadFile{"SelfContaining", "name: &a [*a]\n", "at most 32 levels"},
                      BadFile{"UnknownAlias", "name: *b\n", "not YAML"},
                      BadFile{"AliasBomb", AliasBomb(), "100000 values"},
                      BadFile{"KeyIsList", "[a, b]: c\n", ":1: a key is not a plain word"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(MalformedSceneTest, AMissingFileAndAFolderAreSaidToBeSo) {
  const SceneFolder folder;
  EXPECT_THAT(MistakesOf(folder.path() / "none.yaml"), HasSubstr("none.yaml: no such file"));
  EXPECT_THAT(MistakesOf(folder.path()), HasSubstr("not a file"));
}

TEST(MalformedSceneTest, AllMistakesOfAFileComeAtOnceInItsOrder) {
  const SceneFolder folder;
  std::string text = SmallSceneWith(11, "  contour: {alpha: x}\nsite: {noise: loud}");
  text.replace(text.find("127 kPa"), 7, "127 mm");
  text.replace(text.find("5.87 mm"), 7, "5.87 kg");  // the tool is read after the senses
  const std::string mistakes = MistakesOf(folder.Write("scene.yaml", text + "extra: 1\n"));
  EXPECT_EQ(LineCount(mistakes), 5) << mistakes;
  const auto at = [&](const char* what) { return mistakes.find(what); };
  EXPECT_LT(at(":4: object.material.young_modulus"), at(":7: tool.width"));
  EXPECT_LT(at(":7: tool.width"), at(":11: sense.contour.alpha"));
  EXPECT_LT(at(":11: sense.contour.alpha"), at(":12: site.noise"));
  EXPECT_LT(at(":12: site.noise"), at(":13: extra"));
}

// A fuzzer found that a membrane held by a word ended the program.
TEST(MalformedSceneTest, WhateverStandsInPlaceOfASectionIsReadOrRefused) {
  const std::vector<std::string> sections{"object",
                                          "object.geometry",
                                          "object.material",
                                          "object.fixed",
                                          "object.pose",
                                          "tool",
                                          "sense",
                                          "sense.camera",
                                          "sense.contour",
                                          "sense.tip",
                                          "sense.points",
                                          "sense.tactile",
                                          "model",
                                          "operator",
                                          "operator.press",
                                          "manipulator",
                                          "link",
                                          "site",
                                          "site.motion",
                                          "site.embryo",
                                          "study",
                                          "study.contacts",
                                          "sense.tactile.fingers",
                                          "manipulator.workspace"};
  for (const char* name :
       {"silicone-block", "zebrafish-embryo", "rubber-membrane", "foam-cube", "heart-target"}) {
    const auto file = SourcePath("/deploy/scenes/" + std::string(name) + ".yaml");
    for (const std::string& section : sections) {
      for (const char* instead : {"rim", "3", "[]", "{}", "[1, 2]", "{side: 3}", "[rim]"}) {
        const std::string mistakes = MistakesOf(file, {section + "=" + instead});
        if (std::string_view(instead) != "rim") continue;
        EXPECT_THAT(mistakes, HasSubstr(section + " = rim: accepted is")) << name;
      }
    }
  }
  const std::string mistakes =
      MistakesOf(SourcePath("/deploy/scenes/rubber-membrane.yaml"), {"object.fixed=rim"});
  EXPECT_THAT(mistakes, HasSubstr("object.fixed = rim: accepted is a map of `key: value`"));
}

TEST(MalformedSceneTest, AnImageContourNeedsASnakeAndARealPicture) {
  const SceneFolder folder;
  std::string text = SmallSceneWith(3, "  geometry: {contour: from-image, thickness: 9 mm}");
  text.replace(text.find("side: bottom"), 12, "nodes: [0]");
  text.erase(text.find("  contour: {track"));
  const std::string mistakes = MistakesOf(folder.Write("scene.yaml", text));
  EXPECT_THAT(mistakes, HasSubstr(":8: sense.contour = (missing): accepted is {track: snake}"));
  EXPECT_THAT(mistakes,
              HasSubstr(":9: sense.camera.source = simulated: accepted is file or device"));
}

TEST(MalformedSceneTest, AContourFileIsReportedWithItsOwnLine) {
  const SceneFolder folder;
  const auto file = folder.Write(
      "scene.yaml", SmallSceneWith(3, "  geometry: {contour: outline.csv, thickness: 9 mm}"));
  const struct {
    const char* csv;
    const char* message;
  } kRows[] = {{"x,y\n0,0\n1,zero\n", "outline.csv:3: 1,zero: accepted is two numbers x,y"},
               {"0,0\n1,0\n", "outline.csv: 2 points: accepted is 3 to 4000"},
               {"0,0\n2,2\n2,0\n0,1\n", "cross or touch"}};
  for (const auto& row : kRows) {
    folder.Write("outline.csv", row.csv);
    EXPECT_THAT(MistakesOf(file), HasSubstr(row.message));
    EXPECT_THAT(MistakesOf(file), HasSubstr(":3: object.geometry.contour = outline.csv"));
  }
}

// Overrides are reported as what they are, not as a line of the file.
TEST(MalformedSceneTest, OverridesAreReportedByTheirKey) {
  const SceneFolder folder;
  const auto file = folder.Write("scene.yaml", SmallScene());
  const struct {
    const char* override_pair;
    const char* message;
  } kRows[] = {
      {"model.elements=x",
       "--override model.elements = x: accepted is a whole number from 3 to 4000"},
      {"model.elments=60", "--override model.elments = 60: accepted is `elements` (nearest)"},
      {"nothing.here=1", "--override nothing = {here: 1}: accepted is one of name"},
      {"model.elements", "--override model.elements: accepted is key.path=value"},
      {"=60", "--override =60: accepted is key.path=value"},
      {"name.first=x", "--override name.first = x: accepted is a key path"},
      {"object.fixed.side.0=x", "--override object.fixed.side.0 = x: accepted is a key path"},
      {"model.elements=[", "--override model.elements = [: accepted is a YAML value"},
      {"model.elements=", "--override model.elements = (nothing): accepted is a whole number"},
      {"manipulator.home=[40 mm, 20 mm, 0]",
       "--override manipulator.home = [40 mm, 20 mm, 0]: accepted"},
  };
  for (const auto& row : kRows) {
    const std::string mistakes = MistakesOf(file, {row.override_pair});
    EXPECT_THAT(mistakes, HasSubstr(row.message));
    EXPECT_EQ(LineCount(mistakes), 1) << mistakes;
  }
}

// Broken in the middle of every byte: whatever happens, it is a SceneError or a scene.
TEST(MalformedSceneTest, NoTruncationCrashes) {
  const SceneFolder folder;
  const std::string text = SmallScene();
  int refused = 0;
  for (std::size_t length = 0; length < text.size(); ++length) {
    refused += !MistakesOf(folder.Write("scene.yaml", text.substr(0, length))).empty();
  }
  EXPECT_GT(refused, static_cast<int>(text.size()) / 2);
}

TEST(MalformedSceneTest, NoSingleChangedByteCrashes) {
  const SceneFolder folder;
  const std::string bytes = "\xff\x01:[]{}&*!|>%@`'\"#,-?\n\t~9";
  for (std::size_t i = 0; i < SmallScene().size(); ++i) {
    std::string text = SmallScene();
    text[i] = bytes[i % bytes.size()];
    MistakesOf(folder.Write("scene.yaml", text));
  }
}

// 1000 aliases of 10 kB are 10 MB, from a file of 16 kB.
TEST(HostileSceneTest, AliasesSpellOutNoMoreTextThanIsSaid) {
  const SceneFolder folder;
  std::string text = "name: &a " + std::string(10'000, 'x') + "\nobject: [*a";
  for (int i = 1; i < 1000; ++i) text += ", *a";
  EXPECT_THAT(MistakesOf(folder.Write("scene.yaml", text + "]\n")),
              HasSubstr("too large: accepted is at most 32 levels, 100000 values and 4 MiB"));
}

// Most of a minute where every key is compared with every other.
TEST(HostileSceneTest, OfManyMistakesTheFirstAreListedAndTheOthersCounted) {
  const SceneFolder folder;
  constexpr int kKeys = 90'000;
  std::string text = SmallScene();
  for (int i = 0; i < kKeys; ++i) text += "k" + std::to_string(i) + ": 1\n";
  const std::string mistakes = MistakesOf(folder.Write("scene.yaml", text));
  EXPECT_EQ(LineCount(mistakes), 51);
  EXPECT_THAT(mistakes, HasSubstr("scene.yaml: and 89950 more mistakes"));
}

TEST(HostileSceneTest, QuotesNoMoreOfALongPathThanCanBeRead) {
  const SceneFolder folder;
  const std::string mistakes =
      MistakesOf(folder.Write("scene.yaml", SmallScene() + std::string(1000, 'k') + ": 1\n"));
  EXPECT_THAT(mistakes, HasSubstr(std::string(200, 'k') + "... = 1: accepted is one of name"));
}

// A list's items are found by their place: 30 000 points, each of which is read.
TEST(HostileSceneTest, LongListsAreReadItemByItem) {
  const SceneFolder folder;
  std::string points = "[[0, 0]";
  for (int i = 1; i < 30'000; ++i) points += ", [1, 1]";
  const auto file = folder.Write(
      "scene.yaml",
      SmallSceneWith(3, "  geometry: {polygon: {points: " + points + "], thickness: 9 mm}}"));
  EXPECT_THAT(MistakesOf(file), HasSubstr("accepted is at most 4000 points, holes included"));
}

// A scene may come from anywhere: it must not show what stands in files that are no contour.
TEST(HostileSceneTest, QuotesLittleOfAFileThatIsNoContour) {
  const SceneFolder folder;
  folder.Write("secret", "user:password\nroot:\x1b]0;title\x07$6$saltsaltsaltsalt:19000\n");
  const std::string mistakes = MistakesOf(folder.Write(
      "scene.yaml", SmallSceneWith(3, "  geometry: {contour: secret, thickness: 9 mm}")));
  EXPECT_THAT(mistakes, HasSubstr("secret:2: root:?]0;tit...: accepted is two numbers x,y [m]"));
  EXPECT_THAT(mistakes, testing::Not(HasSubstr("salt")));
}

}  // namespace
}  // namespace palpate
