// Scenes of fingertips: accepted keys with their defaults, and refused ones.
#include <algorithm>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/slave/scene/scene_file.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

constexpr const char* kTouchedBox = "{box: {size: [60 mm, 40 mm, 20 mm], cells: [3, 2, 1]}}";

std::string TouchScene(const std::string& sense, const std::string& geometry = kTouchedBox) {
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
std::string Tactile8(const std::string& keys, const std::string& geometry = kTouchedBox) {
  return TouchScene("  tactile: {" + keys + "}\n", geometry);
}

// A fixture with the files that the scenes below use.
class TactileSceneTest : public ::testing::Test {
 protected:
  TactileSceneTest() {
    for (const char* name : {"rh_tactile.csv", "layout.csv", "fitted.json"}) {
      folder_.Write(name, "");
    }
    std::filesystem::create_directory(folder_.path() / "net");
  }
  Scene Load(const std::string& text, const std::vector<std::string>& overrides = {},
             SceneUse use = SceneUse::kFull) const {
    return LoadScene(folder_.Write("scene.yaml", text), overrides, use);
  }
  std::string MistakesOf(const std::string& text, SceneUse use = SceneUse::kFull) const {
    return Thrown<SceneError>([&] { Load(text, {}, use); });
  }
  Scratch folder_;
};

TEST_F(TactileSceneTest, EveryKeyIsRead) {
  const Scene scene = Load(Tactile8(
      "source: rh_tactile.csv, finger: th, pose: {translation: [0, 0, 50 mm], rotation: [0, 0, 90 "
      "deg]}, network: net, rest: first 7, rate: 0.2 kHz, electrodes: layout.csv, "
      "radius: 6 mm, pose_tolerance: 1 deg, patch: 8 mm, hold: displacement"));
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  const Finger& finger = tactile.fingers.at(0);
  EXPECT_EQ(finger.name, "th");
  EXPECT_TRUE(finger.has_pose);
  EXPECT_TRUE(finger.X_SF.translation().isApprox(Eigen::Vector3d(0, 0, 0.05)));
  EXPECT_TRUE((finger.X_SF.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_EQ(tactile.rest_samples, 7);
  EXPECT_DOUBLE_EQ(tactile.rate, 200);
  EXPECT_EQ(tactile.electrodes, folder_.path() / "layout.csv");
  EXPECT_DOUBLE_EQ(tactile.finger_radius, 6e-3);
  EXPECT_NEAR(tactile.pose_tolerance, 0.0174533, 1e-7);
  EXPECT_DOUBLE_EQ(tactile.patch, 8e-3);
  EXPECT_EQ(tactile.hold, Tactile::Hold::kDisplacement);
  EXPECT_FALSE(tactile.has_recorded_poses);
}

TEST_F(TactileSceneTest, ARecordingMayHaveThePosesOfItsFingers) {
  folder_.Write("rh_tactile.csv", "t,rf_E1,rf_x,rf_y,rf_z,rf_qw,rf_qx,rf_qy,rf_qz\n");
  const Scene scene = Load(Tactile8("source: rh_tactile.csv, finger: rf"));
  EXPECT_TRUE(scene.sense.Find<Tactile>()->has_recorded_poses);
  EXPECT_TRUE(MeetsObject(scene));
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

TEST_F(TactileSceneTest, AMeshIsMeasuredByItsNodes) {
  folder_.Write("tet.node", "4 3 0 0\n1 0 0 0\n2 10 0 0\n3 0 20 0\n4 0 0 40\n");
  folder_.Write("tet.ele", "1 4 0\n1 1 2 3 4\n");
  const Scene scene = Load(Tactile8("source: simulated", "{mesh: tet.node, unit: mm}"));
  EXPECT_LT((scene.manipulator.home - Eigen::Vector3d(0.005, 0.01, 0.04 + 0.07 * 0.04)).norm(),
            1e-15);
  folder_.Write("tet.node", "4 3 0 0\n1 0 0\n");
  EXPECT_THAT(MistakesOf(Tactile8("source: simulated", "{mesh: tet.node, unit: mm}")),
              HasSubstr("3: object.geometry.mesh = tet.node: expected a mesh that can be read; "));
}

TEST_F(TactileSceneTest, FingertipsTouchVolumesAndNothingElse) {
  for (const char* kind : {"auto", "fem", "fem-green"}) {
    EXPECT_NO_THROW(Load(Tactile8("source: simulated"), {std::string("model.kind=") + kind}))
        << kind;
  }
  std::string flat =
      Tactile8("source: simulated", "{rectangle: {width: 80 mm, height: 40 mm, thickness: 9 mm}}");
  flat.replace(flat.find("{plane: {axis: z, at: 0 m}}"), 27, "{side: bottom}");
  flat.replace(flat.find("kind: fem"), 9, "kind: auto");
  EXPECT_THAT(MistakesOf(flat),
              HasSubstr("3: object.geometry = {rectangle: {width: 80 mm, height: 40 mm, thickness: "
                        "9 mm}}: expected box or mesh with fingertips"));
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
    {"NoSource", "finger: rf", "sense.tactile.source = (missing): expected stream, simulated, or"},
    {"NoSuchRecording", "source: none.csv",
     "sense.tactile.source = none.csv: expected stream, simulated, or a CSV recording; there is "
     "no file"},
    {"NoSuchNetwork", "source: stream, network: none",
     "sense.tactile.network = none: expected a folder with network.json; there"},
    {"RestAsNumber", "source: stream, rest: 50",
     "sense.tactile.rest = 50: expected `first N`, N from 1 to 10000 samples"},
    {"FingerAndFingers", "source: stream, finger: rf, fingers: {rf: {}}",
     "sense.tactile.finger = rf: expected nothing with `fingers`"},
    {"SixFingers", "source: stream, fingers: {a: {}, b: {}, c: {}, d: {}, e: {}, f: {}}",
     "sense.tactile.fingers = {a: {}, b: {}, c: {}, d: {}, e: {}, f: {}}: expected a map of 1 "
     "to "
     "5 fingers"},
    {"FirstAtRest", "source: stream, fingers: {rf: {motion: stands}, th: {}}",
     "sense.tactile.fingers.rf.motion = stands: expected hand for the first finger"},
    {"NameWithSpace", "source: stream, finger: ring finger",
     "sense.tactile.finger = ring finger: expected a finger's name of 1 to 32 letters"},
    {"FingerInside", "source: stream, pose: {translation: [30 mm, 20 mm, 10 mm]}",
     "sense.tactile.pose = {translation: [30 mm, 20 mm, 10 mm]}: expected a fingertip whose "
     "centre lies outside the object"},
};
INSTANTIATE_TEST_SUITE_P(Scenes, BadTactileTest, ::testing::ValuesIn(kBad),
                         [](const auto& row) { return std::string(row.param.name); });

TEST_F(TactileSceneTest, HomeIsGivenByThePoseAlone) {
  EXPECT_THAT(MistakesOf(Tactile8("source: stream") + "manipulator: {home: [0, 0, 1]}\n"),
              HasSubstr("9: manipulator.home = [0, 0, 1]: expected nothing here"));
  EXPECT_THAT(MistakesOf(Tactile8("source: stream, pose: {translation: [0, 0, 1]}") +
                         "manipulator: {workspace: {max: [1, 1, 0.1]}}\n"),
              HasSubstr("9: manipulator.workspace = {max: [1, 1, 0.1]}: expected a workspace "
                        "that contains the pad"));
}

TEST_F(TactileSceneTest, ASceneSensesInOneWay) {
  const std::string mistakes = MistakesOf(
      Tactile8("source: stream") + "  camera: {source: simulated, pixel: 1 mm}\n  tip: {}\n");
  EXPECT_THAT(mistakes, HasSubstr("9: sense.camera = {source: simulated, pixel: 1 mm}: expected "
                                  "nothing with `tactile`"));
  EXPECT_THAT(mistakes, HasSubstr("10: sense.tip = {}: expected nothing with `tactile`"));
}

TEST_F(TactileSceneTest, ADepthCamerasMistakesAreReported) {
  const struct {
    const char* keys;
    const char* message;
  } kRows[] = {
      {"size: [640, 480]", "depth_camera.pose = (missing): expected a map of translation"},
      {"pose: {translation: [0, 0, 1]}, focal: 0 px",
       "depth_camera.focal = 0 px: expected a number of pixels"},
      {"pose: {translation: [0, 0, 1]}, size: [640, 480.5]",
       "depth_camera.size = [640, 480.5]: expected whole"},
  };
  for (const auto& row : kRows) {
    EXPECT_THAT(MistakesOf(TouchScene("  tactile: {source: simulated}\n  depth_camera: {" +
                                      std::string(row.keys) + "}\n")),
                HasSubstr(std::string("9: sense.") + row.message));
  }
}

}  // namespace
}  // namespace palpate
