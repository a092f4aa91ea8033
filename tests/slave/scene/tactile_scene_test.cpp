// Scenes of fingertips: what contracts names, with its defaults, and what is refused.
#include <algorithm>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/slave/scene/scene_file.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

constexpr const char* kBox = "{box: {size: [60 mm, 40 mm, 20 mm], cells: [3, 2, 1]}}";

std::string TouchScene(const std::string& sense, const std::string& geometry = kBox) {
  return "name: touch\n"  // 1
         "object:\n"      // 2
         "  geometry: " +
         geometry +
         "\n"                                                           // 3
         "  material: {young_modulus: 3.8 kPa, poisson_ratio: 0.15}\n"  // 4
         "  fixed: {plane: {axis: z, at: 0 m}}\n"                       // 5
         "model: {kind: fem}\n"                                         // 6
         "sense:\n" +
         sense;  // 7
}
// One line `tactile: {...}`, line 8.
std::string Tactile8(const std::string& keys, const std::string& geometry = kBox) {
  return TouchScene("  tactile: {" + keys + "}\n", geometry);
}

// With the files that the scenes below name.
class TactileSceneTest : public ::testing::Test {
 protected:
  TactileSceneTest() {
    for (const char* name : {"rh_tactile.csv", "layout.csv", "fitted.json", "poses.csv"}) {
      folder_.Write(name, "");
    }
    std::filesystem::create_directory(folder_.path() / "net");
  }
  Scene Load(const std::string& text, const std::vector<std::string>& overrides = {},
             SceneUse use = SceneUse::kFull) const {
    return LoadScene(folder_.Write("scene.yaml", text), overrides, use);
  }
  std::string MistakesOf(const std::string& text, SceneUse use = SceneUse::kFull) const {
    try {
      Load(text, {}, use);
      return {};
    } catch (const SceneError& error) {
      return error.what();
    }
  }
  Scratch folder_;
};

// Reference: contracts, `tactile: {source: rh_tactile.csv, finger: rf, network: DIR, rest: first
// 50}`.
TEST_F(TactileSceneTest, TheContractsKeysAreEnough) {
  const Scene scene =
      Load(Tactile8("source: rh_tactile.csv, finger: rf, network: net, rest: first 50"));
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  EXPECT_EQ(tactile.source, Tactile::Source::kRecording);
  EXPECT_EQ(tactile.file, folder_.path() / "rh_tactile.csv");
  EXPECT_EQ(tactile.network, folder_.path() / "net");
  EXPECT_EQ(tactile.rest_samples, 50);
  ASSERT_EQ(tactile.fingers.size(), 1U);
  EXPECT_EQ(tactile.fingers[0].name, "rf");
  EXPECT_FALSE(tactile.fingers[0].has_pose);
  EXPECT_EQ(tactile.rate, 100);
  EXPECT_TRUE(tactile.electrodes.empty());
  EXPECT_EQ(tactile.localise, "auto");
  EXPECT_EQ(tactile.threshold, 5);
  EXPECT_DOUBLE_EQ(tactile.finger_radius, 7e-3);
  EXPECT_DOUBLE_EQ(tactile.pose_tolerance, 0.035);
  EXPECT_EQ(tactile.patch, 0);
  EXPECT_EQ(tactile.hold, Tactile::Hold::kForce);
  EXPECT_TRUE(tactile.poses.empty());
  EXPECT_FALSE(scene.sense.Find<Camera>() || scene.sense.Find<TipTracking>() ||
               scene.sense.Find<ContourTracking>() || scene.tool);
}

TEST_F(TactileSceneTest, EveryKeyIsRead) {
  const Scene scene = Load(Tactile8(
      "source: rh_tactile.csv, finger: th, pose: {translation: [0, 0, 50 mm], rotation: [0, 0, 90 "
      "deg]}, network: net, rest: first 7, rate: 0.2 kHz, electrodes: layout.csv, localise: "
      "paper, threshold: 3, radius: 6 mm, pose_tolerance: 1 deg, patch: 8 mm, hold: displacement, "
      "poses: poses.csv"));
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  const Finger& finger = tactile.fingers.at(0);
  EXPECT_EQ(finger.name, "th");
  EXPECT_TRUE(finger.has_pose);
  EXPECT_TRUE(finger.X_SF.translation().isApprox(Eigen::Vector3d(0, 0, 0.05)));
  EXPECT_TRUE((finger.X_SF.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_EQ(tactile.rest_samples, 7);
  EXPECT_DOUBLE_EQ(tactile.rate, 200);
  EXPECT_EQ(tactile.electrodes, folder_.path() / "layout.csv");
  EXPECT_EQ(tactile.localise, "paper");
  EXPECT_EQ(tactile.threshold, 3);
  EXPECT_DOUBLE_EQ(tactile.finger_radius, 6e-3);
  EXPECT_NEAR(tactile.pose_tolerance, 0.0174533, 1e-7);
  EXPECT_DOUBLE_EQ(tactile.patch, 8e-3);
  EXPECT_EQ(tactile.hold, Tactile::Hold::kDisplacement);
  EXPECT_EQ(tactile.poses, folder_.path() / "poses.csv");
}

TEST_F(TactileSceneTest, FingersComeInTheFilesOrderWithTheirMotions) {
  const Scene scene =
      Load(TouchScene("  tactile:\n"
                      "    source: simulated\n"
                      "    fingers:\n"
                      "      th: {pose: {translation: [30 mm, 20 mm, 40 mm]}}\n"
                      "      ff: {pose: {translation: [30 mm, 20 mm, -20 mm]}, motion: opposite}\n"
                      "      lf: {motion: stands}\n"));
  const auto& fingers = scene.sense.Find<Tactile>()->fingers;
  ASSERT_EQ(fingers.size(), 3U);
  EXPECT_EQ(fingers[0].name, "th");
  EXPECT_EQ(fingers[0].motion, Finger::Motion::kHand);
  EXPECT_EQ(fingers[1].name, "ff");
  EXPECT_EQ(fingers[1].motion, Finger::Motion::kOpposite);
  EXPECT_EQ(fingers[2].motion, Finger::Motion::kStands);
  EXPECT_TRUE(fingers[1].has_pose);
  EXPECT_FALSE(fingers[2].has_pose);
}

// Reference: home is X_SF (0, 0, -radius); the turn by 90 degrees about x takes -z to y.
TEST_F(TactileSceneTest, HomeIsTheApexOfTheFirstFingersPad) {
  const Scene scene = Load(Tactile8(
      "source: simulated, pose: {translation: [30 mm, -20 mm, 10 mm], rotation: [90 deg, 0, 0]}"));
  EXPECT_LT((scene.manipulator.home - Eigen::Vector3d(0.03, -0.013, 0.01)).norm(), 1e-15);
}

// Reference: sections.h; the object is a box of 60 x 40 x 20 mm.
TEST_F(TactileSceneTest, MotionIsMeasuredByTheBoxInAllThreeAxes) {
  const double side = 0.06;
  const Scene scene = Load(Tactile8("source: simulated"));
  EXPECT_LT((scene.manipulator.home - Eigen::Vector3d(0.03, 0.02, 0.02 + 0.07 * side)).norm(),
            1e-15);
  EXPECT_TRUE(scene.manipulator.workspace_min.isApprox(Eigen::Vector3d(-side, -side, -side)));
  EXPECT_TRUE(scene.manipulator.workspace_max.isApprox(
      Eigen::Vector3d(2 * side, 0.04 + side, 0.02 + side)));
  EXPECT_DOUBLE_EQ(scene.operator_options.press_depth, 0.055 * side);
}

TEST_F(TactileSceneTest, AWorkspaceByDefaultHoldsAFarFingersPad) {
  const Scene scene = Load(Tactile8("source: stream, pose: {translation: [0, 0, 1 m]}"));
  EXPECT_DOUBLE_EQ(scene.manipulator.workspace_max.z(), scene.manipulator.home.z());
}

TEST_F(TactileSceneTest, TheBoxStandsWhereTheObjectStands) {
  std::string text = Tactile8("source: simulated");
  text.insert(text.find("  material"),
              "  pose: {translation: [1, 2, 3], rotation: [90 deg, 0, 0]}\n");
  const Scene scene = Load(text);  // 60 x 20 x 40 mm now, lower corner (1, 1.98, 3)
  EXPECT_LT((scene.manipulator.home - Eigen::Vector3d(1.03, 1.99, 3.04 + 0.07 * 0.06)).norm(),
            1e-12);
}

TEST_F(TactileSceneTest, AMeshIsMeasuredByItsNodes) {
  folder_.Write("tet.veg",
                "*VERTICES\n4 3 0 0\n1 0 0 0\n2 10 0 0\n3 0 20 0\n4 0 0 40\n\n*ELEMENTS\nTETS\n1 4 "
                "0\n1 1 2 3 4\n");
  const Scene scene = Load(Tactile8("source: simulated", "{mesh: tet.veg, unit: mm}"));
  EXPECT_LT((scene.manipulator.home - Eigen::Vector3d(0.005, 0.01, 0.04 + 0.07 * 0.04)).norm(),
            1e-15);
  folder_.Write("tet.veg", "*VERTICES\n4 3 0 0\n1 0 0\n");
  EXPECT_THAT(
      MistakesOf(Tactile8("source: simulated", "{mesh: tet.veg, unit: mm}")),
      HasSubstr("3: object.geometry.mesh = tet.veg: accepted is a mesh that can be read; "));
}

TEST_F(TactileSceneTest, SolveTakesASceneWhoseFilesAreElsewhere) {
  const std::string text = Tactile8("source: away.csv, network: away, electrodes: away.csv");
  EXPECT_NO_THROW(Load(text, {}, SceneUse::kSolve));
  const std::string mistakes = MistakesOf(text);
  EXPECT_EQ(std::count(mistakes.begin(), mistakes.end(), '\n'), 2) << mistakes;
}

TEST_F(TactileSceneTest, ADepthCameraStandsWhereItIsSaidTo) {
  const Scene scene = Load(TouchScene(
      "  tactile: {source: simulated}\n"
      "  depth_camera: {pose: {translation: [0, 0, 1 m], rotation: [180 deg, 0, 0]}, size: [320, "
      "240], focal: 260 px, noise: 5 mm}\n"));
  const DepthCamera& camera = *scene.sense.depth_camera;
  EXPECT_TRUE((camera.X_SD * Eigen::Vector3d(0, 0, 1)).isZero(1e-15));
  EXPECT_EQ(camera.size, (std::array{320, 240}));
  EXPECT_EQ(camera.focal, 260);
  EXPECT_DOUBLE_EQ(camera.noise, 5e-3);
  const Scene plain =
      Load(TouchScene("  depth_camera: {pose: {rotation: [0, 0, 0]}}\n"), {}, SceneUse::kSolve);
  EXPECT_EQ(plain.sense.depth_camera->size, (std::array{640, 480}));
  EXPECT_EQ(plain.sense.depth_camera->focal, 525);
  EXPECT_DOUBLE_EQ(plain.sense.depth_camera->noise, 2e-3);
}

TEST_F(TactileSceneTest, FingertipsTouchVolumesAndNothingElse) {
  for (const char* kind : {"auto", "fem", "fem-green", "fem-zone"}) {
    EXPECT_NO_THROW(Load(Tactile8("source: simulated"), {std::string("model.kind=") + kind}))
        << kind;
  }
  std::string flat =
      Tactile8("source: simulated", "{rectangle: {width: 80 mm, height: 40 mm, thickness: 9 mm}}");
  flat.replace(flat.find("{plane: {axis: z, at: 0 m}}"), 27, "{side: bottom}");
  flat.replace(flat.find("kind: fem"), 9, "kind: auto");
  EXPECT_THAT(MistakesOf(flat),
              HasSubstr("3: object.geometry = {rectangle: {width: 80 mm, height: 40 mm, thickness: "
                        "9 mm}}: accepted is box or mesh with fingertips"));
  EXPECT_EQ(MistakesOf(flat, SceneUse::kSolve), "");
}

struct BadTactile {
  const char* name;
  const char* keys;
  const char* message;
};

class BadTactileTest : public TactileSceneTest, public ::testing::WithParamInterface<BadTactile> {};

TEST_P(BadTactileTest, IsReportedOnceWithItsPlace) {
  const std::string mistakes = MistakesOf(Tactile8(GetParam().keys));
  EXPECT_THAT(mistakes, HasSubstr(std::string("scene.yaml:8: ") + GetParam().message));
  EXPECT_EQ(std::count(mistakes.begin(), mistakes.end(), '\n'), 0) << mistakes;
}

const BadTactile kBad[] = {
    {"NoSource", "finger: rf",
     "sense.tactile.source = (missing): accepted is stream, simulated, or"},
    {"NoSuchRecording", "source: none.csv",
     "sense.tactile.source = none.csv: accepted is stream, simulated, or a CSV recording; there is "
     "no file"},
    {"NoSuchNetwork", "source: stream, network: none",
     "sense.tactile.network = none: accepted is a folder with network.json; there"},
    {"NoSuchLayout", "source: stream, electrodes: none.csv",
     "sense.tactile.electrodes = none.csv: accepted is a file that exists"},
    {"NoSuchPoses", "source: rh_tactile.csv, poses: none.csv",
     "sense.tactile.poses = none.csv: accepted is a file that exists"},
    {"PosesOfAStream", "source: stream, poses: poses.csv",
     "sense.tactile.poses = poses.csv: accepted is nothing here: only a recording"},
    {"NoSuchLocaliser", "source: stream, localise: polarity-free",
     "sense.tactile.localise = polarity-free: accepted is auto, paper or pressure-weighted"},
    {"UnknownKey", "source: stream, treshold: 5",
     "sense.tactile.treshold = 5: accepted is `threshold` (nearest)"},
    {"ThinFinger", "source: stream, radius: 0.5 mm",
     "sense.tactile.radius = 0.5 mm: accepted is a length in m mm um nm km, 1 mm to 50 mm"},
    {"PosesThatNobodyKnows", "source: stream, pose_tolerance: 60 deg",
     "sense.tactile.pose_tolerance = 60 deg: accepted is an angle in rad deg, 0 to 28 deg"},
    {"RestAsNumber", "source: stream, rest: 50",
     "sense.tactile.rest = 50: accepted is `first N`, N from 1 to 10000 samples"},
    {"NoSuchHold", "source: stream, hold: still",
     "sense.tactile.hold = still: accepted is force or displacement"},
    {"FingerAndFingers", "source: stream, finger: rf, fingers: {rf: {}}",
     "sense.tactile.finger = rf: accepted is nothing with `fingers`"},
    {"PoseBesideFingers", "source: stream, pose: {}, fingers: {rf: {}}",
     "sense.tactile.pose = {}: accepted is nothing with `fingers`"},
    {"SixFingers", "source: stream, fingers: {a: {}, b: {}, c: {}, d: {}, e: {}, f: {}}",
     "sense.tactile.fingers = {a: {}, b: {}, c: {}, d: {}, e: {}, f: {}}: accepted is a map of 1 "
     "to "
     "5 fingers"},
    {"NoFingers", "source: stream, fingers: {}",
     "sense.tactile.fingers = {}: accepted is a map of 1 to 5 fingers"},
    {"FingersAsList", "source: stream, fingers: [rf]",
     "sense.tactile.fingers = [rf]: accepted is a map of `key: value`"},
    {"TwiceTheSame", "source: stream, fingers: {rf: {}, rf: {}}",
     "sense.tactile.fingers.rf = {}: accepted is each key once"},
    {"FirstStands", "source: stream, fingers: {rf: {motion: stands}, th: {}}",
     "sense.tactile.fingers.rf.motion = stands: accepted is hand for the first finger"},
    {"NoSuchMotion", "source: stream, fingers: {rf: {}, th: {motion: up}}",
     "sense.tactile.fingers.th.motion = up: accepted is hand or opposite or stands"},
    {"NameWithSpace", "source: stream, finger: ring finger",
     "sense.tactile.finger = ring finger: accepted is a finger's name of 1 to 32 letters"},
    {"LongName", "source: stream, fingers: {aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa: {}}",
     "sense.tactile.fingers.aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa = {}: accepted is a finger's name"},
    {"FingerInside", "source: stream, pose: {translation: [30 mm, 20 mm, 10 mm]}",
     "sense.tactile.pose = {translation: [30 mm, 20 mm, 10 mm]}: accepted is a fingertip whose "
     "centre lies outside the object"},
    {"SecondInside",
     "source: stream, fingers: {a: {}, b: {pose: {translation: [30 mm, 20 mm, 1 mm]}}}",
     "sense.tactile.fingers.b.pose = {translation: [30 mm, 20 mm, 1 mm]}: accepted is a fingertip"},
};
INSTANTIATE_TEST_SUITE_P(Scenes, BadTactileTest, ::testing::ValuesIn(kBad),
                         [](const auto& row) { return std::string(row.param.name); });

TEST_F(TactileSceneTest, HomeIsSaidByThePoseAlone) {
  EXPECT_THAT(MistakesOf(Tactile8("source: stream") + "manipulator: {home: [0, 0, 1]}\n"),
              HasSubstr("9: manipulator.home = [0, 0, 1]: accepted is nothing here"));
  EXPECT_THAT(MistakesOf(Tactile8("source: stream, pose: {translation: [0, 0, 1]}") +
                         "manipulator: {workspace: {max: [1, 1, 0.1]}}\n"),
              HasSubstr("9: manipulator.workspace = {max: [1, 1, 0.1]}: accepted is a workspace "
                        "that contains the pad"));
}

TEST_F(TactileSceneTest, AThresholdInPercentOrBeyondFullIntensityIsRefused) {
  EXPECT_THAT(MistakesOf(Tactile8("source: stream, threshold: 500 %")),
              HasSubstr("sense.tactile.threshold = 500 %: accepted is a plain number"));
  EXPECT_THAT(MistakesOf(Tactile8("source: stream, threshold: 300")),
              HasSubstr("sense.tactile.threshold = 300: accepted is"));
}

TEST_F(TactileSceneTest, ASceneSensesInOneWay) {
  const std::string mistakes = MistakesOf(
      Tactile8("source: stream") + "  camera: {source: simulated, pixel: 1 mm}\n  tip: {}\n");
  EXPECT_THAT(mistakes, HasSubstr("9: sense.camera = {source: simulated, pixel: 1 mm}: accepted is "
                                  "nothing with `tactile`"));
  EXPECT_THAT(mistakes, HasSubstr("10: sense.tip = {}: accepted is nothing with `tactile`"));
}

// The cue sets the model's force to zero, which fingertips do not use.
TEST_F(TactileSceneTest, PunctureIsRefusedWithFingertips) {
  std::string text = Tactile8("source: stream");
  const std::string model = "model: {kind: fem";
  text.insert(text.find(model) + model.size(), ", puncture: {depth: 2 mm}");
  for (const SceneUse use : {SceneUse::kFull, SceneUse::kSolve}) {
    EXPECT_THAT(MistakesOf(text, use),
                HasSubstr("6: model.puncture.depth = 2 mm: accepted is nothing with fingertips"));
  }
}

TEST_F(TactileSceneTest, ADepthCamerasMistakesAreSaid) {
  const struct {
    const char* keys;
    const char* message;
  } kRows[] = {
      {"size: [640, 480]", "depth_camera.pose = (missing): accepted is a map of translation"},
      {"pose: {}", "depth_camera.pose = {}: accepted is a map of translation"},
      {"pose: {translation: [0, 0, 1001 m]}",
       "depth_camera.pose.translation.2 = 1001 m: accepted is a length"},
      {"pose: {translation: [0, 0, 1]}, focal: 0 px",
       "depth_camera.focal = 0 px: accepted is a number of pixels"},
      {"pose: {translation: [0, 0, 1]}, noise: -1 mm",
       "depth_camera.noise = -1 mm: accepted is a length"},
      {"pose: {translation: [0, 0, 1]}, size: [640, 480.5]",
       "depth_camera.size = [640, 480.5]: accepted is whole"},
      {"pose: {translation: [0, 0, 1]}, fokal: 525",
       "depth_camera.fokal = 525: accepted is `focal` (nearest)"},
  };
  for (const auto& row : kRows) {
    EXPECT_THAT(MistakesOf(TouchScene("  tactile: {source: simulated}\n  depth_camera: {" +
                                      std::string(row.keys) + "}\n")),
                HasSubstr(std::string("9: sense.") + row.message));
  }
}

// Cut off anywhere, or with any byte changed: a scene or a SceneError.
TEST_F(TactileSceneTest, NoBrokenTextCrashes) {
  const std::string text = Tactile8(
      "source: stream, fingers: {a: {pose: {translation: [0, 0, 1]}}, b: {motion: stands}}, rest: "
      "first 50, localise: paper");
  const std::string bytes = "\xff\x01:[]{}&*!|>%@`'\"#,-?\n\t~9";
  int refused = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] = bytes[i % bytes.size()];
    refused += !MistakesOf(changed).empty();
    refused += !MistakesOf(text.substr(0, i)).empty();
  }
  EXPECT_GT(refused, static_cast<int>(text.size()));
}

}  // namespace
}  // namespace palpate
