// Every mistake in a scene gives a message with its position and the accepted values.
#include <algorithm>
#include <map>
#include <ostream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "shared/text/text.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/scene/scene_file.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// Returns the error message of LoadScene; empty: no error.
std::string MistakesOf(const std::filesystem::path& file,
                       const std::vector<std::string>& overrides = {},
                       SceneUse use = SceneUse::kFull) {
  return Thrown<SceneError>([&] { LoadScene(file, overrides, use); });
}

int LineCount(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n')) + (text.empty() ? 0 : 1);
}

// The text of a line of SmallScene and the key whose value it contains.
struct Place {
  const char* begins;
  const char* key;
};
const std::map<int, Place> kPlaces{{1, {"name: ", "name"}},
                                   {3, {"  geometry: ", "object.geometry"}},
                                   {4, {"  material: ", "object.material"}},
                                   {5, {"  fixed: ", "object.fixed"}},
                                   {6, {"model: ", "model"}},
                                   {7, {"tool: ", "tool"}},
                                   {9, {"  camera: ", "sense.camera"}},
                                   {10, {"  tip: ", "sense.tip"}},
                                   {11, {"  contour: ", "sense.contour"}},
                                   {12, {"", ""}}};

// A changed value in a line of SmallScene that causes exactly one mistake. The message quotes the
// value or says that it is missing.
struct BadLine {
  int line;
  const char* value;
  const char* key;
  const char* accepted;

  friend std::ostream& operator<<(std::ostream& out, const BadLine& bad) {
    return out << "line " << bad.line << ": " << bad.value;
  }
};

class BadLineTest : public ::testing::TestWithParam<BadLine> {};

TEST_P(BadLineTest, IsReportedOnceWithItsPlace) {
  const auto& [line, value, key, accepted] = GetParam();
  const Place& place = kPlaces.at(line);
  const Scratch folder;
  const auto file =
      folder.Write("scene.yaml", SmallSceneWith(line, place.begins + std::string(value)));
  const std::string mistakes = MistakesOf(file);
  const std::string begins = fmt::format("{}:{}: {}{} = ", file.string(), line, place.key, key);
  ASSERT_THAT(mistakes, HasSubstr(begins));
  const std::string quoted =
      mistakes.substr(begins.size(), mistakes.find(": expected ") - begins.size());
  EXPECT_TRUE(quoted == "(missing)" || std::string(value).find(quoted) != std::string::npos)
      << mistakes;
  EXPECT_THAT(mistakes, HasSubstr(std::string(": expected ") + accepted));
  EXPECT_EQ(LineCount(mistakes), 1) << mistakes;
}

const BadLine kBadLines[] = {
    {1, "[a]", "", "a name"},
    {3, "{rectangle: {width: 80 kPa, height: 1, thickness: 1}}", ".rectangle.width",
     "a length > 0 (m, mm, um, nm, km)"},
    {3, "{rectangle: {width: .nan, height: 1, thickness: 1}}", ".rectangle.width", "a length"},
    {3, "{rectangle: {width: 1, height: 1}, disc: {radius: 1 mm}}", "", ""},
    {3, "{polygon: {points: [[0, 0], [2, 2], [2, 0], [0, 1]], thickness: 9 mm}}", ".polygon.points",
     "a simple polygon with holes inside; outer loop: edges 0 and 2 cross or touch"},
    {3, "{polygon: {points: [[0, 0], [2, 2, 2], [2, 0]], thickness: 9 mm}}", ".polygon.points.1",
     "a list of 2 numbers"},
    {3, "{contour: missing.csv, thickness: 9 mm}", ".contour", "from-image, or a CSV file of x,y"},
    {4, "{young_modulus: 1, poisson_ratio: 0.4, young_modulus: 2}", ".young_modulus",
     "each key once: it is already in line 4"},
    {5, "{side: front}", ".side", "bottom, top, left, right or rim"},
    {5, "{arc: {centre: 0 deg, half_angle: 10 deg}}", ".arc", "no arc with this geometry"},
    {5, "{side: top, nodes: [1]}", "", "exactly one of side, arc, plane, nodes"},
    {5, "{nodes: [0, 180]}", "", "nodes from 0 to 179"},
    {5, "{plane: {at: 0 m}}", ".plane.axis", "x or y"},
    {6, "{kind: fem}", ".kind", "auto, bem2d or extruded for a planar outline"},
    {6, "{kind: bem2d, order: cubic}", ".order", "constant or linear or quadratic"},
    {7, "{shape: flat}", ".width", "a length"},
    {7, "{width: 1 mm, radius: 1 mm}", ".radius", "nothing with a flat tool"},
    {7, "{shape: round, width: 5 mm, radius: 2 mm}", ".radius", "at least half of tool.width"},
    {9, "{source: simulated, device: 0, pixel: 1 mm}", ".source",
     "exactly one of `source: simulated`, `file`, `device`, `stereo` and `depth`, or `url` or "
     "`source: stream`"},
    {9, "{file: \"%s%n.png\", pixel: 1 mm}", ".file", "one number such as %d or %04d"},
    {9, "{file: \"none%04d.png\", pixel: 1 mm}", ".file", "a pattern that matches a file; none is"},
    {9, "{source: simulated, pixel: 1 mm, size: [640]}", ".size",
     "a list of 2 numbers, each a number of pixels"},
    {10, "{track: ssd}", ".track", "template in this version"},
    {12, "manipulator: {silence: 50 ms}", "manipulator.silence", "nothing here"},
    {12, "link: {dead_after: 9 ms}", "link.dead_after", "a time, 10 to 500 ms (s, ms, us)"},
    {12, "manipulator: {home: [9 m, 0, 0]}", "manipulator.home",
     "a position inside the manipulator's workspace"},
    {12, "manipulator: {home: [40 mm, 20 mm, 0]}", "manipulator.home",
     "a position outside the object"},
    {12, "manipulator: {workspace: {min: [1, 0, 0], max: [0, 1, 0]}}", "manipulator.workspace.max",
     "a corner with no coordinate below"},
    {12, "site: {embryo: {debris: 3}}", "site.embryo", "a disc, or a contour from the image"},
    {12, "sites: {}", "sites", "`site` (nearest) or another of name, object"},
};
INSTANTIATE_TEST_SUITE_P(Scene, BadLineTest, ::testing::ValuesIn(kBadLines));

using MalformedSceneTest = FolderTest;

// A whole file that is no scene: one mistake, containing the message.
struct BadFile {
  const char* name;
  std::string text;
  const char* message;
};

class BadFileTest : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadFileTest, IsRefusedWithItsReason) {
  const Scratch folder;
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

const BadFile kBadFiles[] = {
    {"Empty", "", "empty: expected a map of name, object, model"},
    {"Word", "hello", "not a scene: expected a map"},
    {"BrokenYaml", "name: a\nobject: {geometry: [\n", "not YAML"},
    {"TwoDocuments", "name: a\n---\nname: b\n", ":2: a second document"},
    // yaml-cpp would return an endless sequence of documents for this text.
    {"CommaAlone", "name: a\n ,b: c\n", "not YAML"},
    {"NotUtf8", "name: M\xFCller\n", ":1: byte 0xFC is not UTF-8: expected a scene in UTF-8"},
    {"Tab", "name: a\nobject:\n\tgeometry: 1\n", "line 3 begins with a tab: expected blanks"},
    {"Binary", std::string("name: \0\1\2", 9), "not text"},
    {"TooLarge", std::string((1 << 20) + 1, '#'), "at most 1 MiB"},
    {"Deep", "name: " + std::string(100, '[') + std::string(100, ']'), "at most 32 levels"},
    {"SelfContaining", "name: &a [*a]\n", "at most 32 levels"},
    {"AliasBomb", AliasBomb(), "100000 values"},
    {"KeyIsList", "[a, b]: c\n", ":1: a key is not a plain word"},
};
INSTANTIATE_TEST_SUITE_P(Files, BadFileTest, ::testing::ValuesIn(kBadFiles),
                         [](const auto& row) { return std::string(row.param.name); });

TEST_F(MalformedSceneTest, AllMistakesOfAFileComeAtOnceInItsOrder) {
  std::string text = SmallSceneWith(11, "  contour: {alpha: x}\nsite: {noise: loud}");
  text.replace(text.find("127 kPa"), 7, "127 mm");
  text.replace(text.find("5.87 mm"), 7, "5.87 kg");  // the tool is read after the senses
  const std::string mistakes = MistakesOf(Write("scene.yaml", text + "extra: 1\n"));
  EXPECT_EQ(LineCount(mistakes), 5) << mistakes;
  const auto at = [&](const char* what) { return mistakes.find(what); };
  EXPECT_LT(at(":4: object.material.young_modulus"), at(":7: tool.width"));
  EXPECT_LT(at(":7: tool.width"), at(":11: sense.contour.alpha"));
  EXPECT_LT(at(":11: sense.contour.alpha"), at(":12: site.noise"));
  EXPECT_LT(at(":12: site.noise"), at(":13: extra"));
}

// A fuzzer found that a word as `fixed` of a membrane ended the program.
TEST_F(MalformedSceneTest, WhateverIsInPlaceOfASectionIsReadOrRefused) {
  const std::string sections =
      "object object.geometry object.material object.fixed object.pose tool sense sense.camera "
      "sense.contour sense.tip sense.points sense.tactile model operator operator.press "
      "manipulator "
      "link site site.motion site.embryo study study.contacts sense.tactile.fingers "
      "manipulator.workspace";
  for (const char* name :
       {"silicone-block", "zebrafish-embryo", "rubber-membrane", "foam-cube", "heart-target"}) {
    const auto file = SourcePath("/deploy/scenes/" + std::string(name) + ".yaml");
    std::istringstream each(sections);
    for (std::string section; each >> section;) {
      for (const char* instead : {"rim", "3", "[]", "{}", "[1, 2]", "{side: 3}", "[rim]"}) {
        const std::string mistakes = MistakesOf(file, {section + "=" + instead});
        if (std::string_view(instead) != "rim") continue;
        EXPECT_THAT(mistakes, HasSubstr(section + " = rim: expected")) << name;
      }
    }
  }
  const std::string mistakes =
      MistakesOf(SourcePath("/deploy/scenes/rubber-membrane.yaml"), {"object.fixed=rim"});
  EXPECT_THAT(mistakes, HasSubstr("object.fixed = rim: expected a map of `key: value`"));
}

TEST_F(MalformedSceneTest, AContourFileIsReportedWithItsOwnLine) {
  const auto file =
      Write("scene.yaml", SmallSceneWith(3, "  geometry: {contour: outline.csv, thickness: 9 mm}"));
  const struct {
    const char* csv;
    const char* message;
  } kRows[] = {{"x,y\n0,0\n1,zero\n", "outline.csv:3: y = zero: expected a finite number"},
               {"0,0,0\n1,1,0\n2,1,1\n", "outline.csv:1: 3 cells: expected 2"},
               {"u,v\n0,0\n1,0\n", "outline.csv:1: no column x: expected x,y"},
               {"0,0\n1,0\n", "outline.csv: 2 points: expected 3 to 4000"},
               {"0,0\n2,2\n2,0\n0,1\n", "cross or touch"}};
  for (const auto& row : kRows) {
    Write("outline.csv", row.csv);
    EXPECT_THAT(MistakesOf(file), HasSubstr(row.message));
    EXPECT_THAT(MistakesOf(file), HasSubstr(":3: object.geometry.contour = outline.csv"));
  }
}

// A mistake in an override is reported as such, not with a line of the file.
TEST_F(MalformedSceneTest, OverridesAreReportedByTheirKey) {
  const auto file = Write("scene.yaml", SmallScene());
  const struct {
    const char* override_pair;
    const char* message;
  } kRows[] = {
      {"model.elements=x", "--override model.elements = x: expected a whole number from 3 to 4000"},
      {"model.elments=60", "--override model.elments = 60: expected `elements` (nearest)"},
      {"nothing.here=1", "--override nothing = {here: 1}: expected one of name"},
      {"model.elements", "--override model.elements: expected key.path=value"},
      {"=60", "--override =60: expected key.path=value"},
      {"name.first=x", "--override name.first = x: expected a key path"},
      {"object.fixed.side.0=x", "--override object.fixed.side.0 = x: expected a key path"},
      {"model.elements=[", "--override model.elements = [: expected a YAML value"},
      {"model.elements=", "--override model.elements = (nothing): expected a whole number"},
      {"manipulator.home=[40 mm, 20 mm, 0]",
       "--override manipulator.home = [40 mm, 20 mm, 0]: expected"},
  };
  for (const auto& row : kRows) {
    const std::string mistakes = MistakesOf(file, {row.override_pair});
    EXPECT_THAT(mistakes, HasSubstr(row.message));
    EXPECT_EQ(LineCount(mistakes), 1) << mistakes;
  }
}

// A scene truncated at every byte gives either a SceneError or a scene.
TEST_F(MalformedSceneTest, NoTruncationCrashes) {
  const std::string text = SmallScene();
  int refused = 0;
  for (std::size_t length = 0; length < text.size(); ++length) {
    refused += !MistakesOf(Write("scene.yaml", text.substr(0, length))).empty();
  }
  EXPECT_GT(refused, static_cast<int>(text.size()) / 2);
}

TEST_F(MalformedSceneTest, NoSingleChangedByteCrashes) {
  const std::string bytes = "\xff\x01:[]{}&*!|>%@`'\"#,-?\n\t~9";
  for (std::size_t i = 0; i < SmallScene().size(); ++i) {
    std::string text = SmallScene();
    text[i] = bytes[i % bytes.size()];
    MistakesOf(Write("scene.yaml", text));
  }
}

using HostileSceneTest = FolderTest;

// 1000 aliases of 10 kB are 10 MB, from a file of 16 kB.
TEST_F(HostileSceneTest, ExpandedAliasesAreLimitedInSize) {
  std::string text = "name: &a " + std::string(10'000, 'x') + "\nobject: [*a";
  for (int i = 1; i < 1000; ++i) text += ", *a";
  EXPECT_THAT(MistakesOf(Write("scene.yaml", text + "]\n")),
              HasSubstr("too large: expected at most 32 levels, 100000 values and 4 MiB"));
}

// This would take most of a minute if every key were compared with every other.
TEST_F(HostileSceneTest, OfManyMistakesTheFirstAreListedAndTheOthersCounted) {
  constexpr int kKeys = 90'000;
  std::string text = SmallScene();
  for (int i = 0; i < kKeys; ++i) text += "k" + std::to_string(i) + ": 1\n";
  const std::string mistakes = MistakesOf(Write("scene.yaml", text));
  EXPECT_EQ(LineCount(mistakes), 51);
  EXPECT_THAT(mistakes, HasSubstr("scene.yaml: and 89950 more mistakes"));
}

// Keys, values and file names from a client appear in the message to it.
TEST_F(HostileSceneTest, WhatIsQuotedIsShort) {
  const std::string is_long(100'000, 'a');
  const std::string outline =
      "object: {geometry: {contour: \"" + is_long + "\", thickness: 9 mm}}\n";
  const std::string umlauts = "? \"" + std::string(59, 'a') + "\xc3\xa4\xc3\xa4\"\n: 1\n";
  for (const std::string& text :
       {"? \"5 object." + is_long + "\"\n: 1\n", "? \"1" + is_long + "\"\n:\n", outline,
        "name: [*" + is_long + "]\n", umlauts}) {
    try {
      LoadScene(Write("scene.yaml", text));
      ADD_FAILURE() << text.substr(0, 40);
    } catch (const SceneError& error) {
      ASSERT_FALSE(error.mistakes().empty());
      for (const SceneMistake& mistake : error.mistakes()) {
        EXPECT_LT(mistake.key.size(), 100U);
        EXPECT_LT(mistake.value.size(), 100U);
        EXPECT_LT(mistake.message.size(), 300U);
        EXPECT_LT(mistake.expected.size(), 2010U);
        EXPECT_EQ(FindInvalidUtf8(mistake.key), std::string::npos);
      }
    }
  }
}

TEST_F(HostileSceneTest, AMistakeIsDataToo) {
  const std::string text = SmallScene() + "nothing: {here: 1}\n";
  try {
    LoadScene(Write("scene.yaml", text));
    ADD_FAILURE();
  } catch (const SceneError& error) {
    ASSERT_EQ(error.mistakes().size(), 1U);
    const SceneMistake& mistake = error.mistakes().front();
    EXPECT_EQ(mistake.key, "nothing");
    EXPECT_EQ(mistake.value, "{here: 1}");
    EXPECT_EQ(mistake.line, LineCount(SmallScene()) + (SmallScene().ends_with('\n') ? 0 : 1));
    EXPECT_THAT(mistake.expected, HasSubstr("one of name"));
  }
}

// Items of a list are accessed by index: all of 30 000 points are read.
TEST_F(HostileSceneTest, LongListsAreReadItemByItem) {
  std::string points = "[[0, 0]";
  for (int i = 1; i < 30'000; ++i) points += ", [1, 1]";
  const auto file =
      Write("scene.yaml",
            SmallSceneWith(3, "  geometry: {polygon: {points: " + points + "], thickness: 9 mm}}"));
  EXPECT_THAT(MistakesOf(file), HasSubstr("expected at most 4000 points, holes included"));
}

// A scene may come from an untrusted client: messages must not reveal the content of other files.
TEST_F(HostileSceneTest, QuotesLittleOfAFileThatIsNoContour) {
  Write("secret", "user:password\nroot:\x1b]0;title\x07$6$saltsaltsaltsalt:19000\n");
  const std::string mistakes = MistakesOf(
      Write("scene.yaml", SmallSceneWith(3, "  geometry: {contour: secret, thickness: 9 mm}")));
  EXPECT_THAT(mistakes, HasSubstr("secret:1: no column x: expected x,y"));
  EXPECT_THAT(mistakes, testing::Not(HasSubstr("salt")));
}

}  // namespace
}  // namespace palpate
