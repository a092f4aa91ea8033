// Scenes of two cameras and of depth pictures: keys, defaults, and what is refused.
#include <algorithm>
#include <filesystem>
#include <ostream>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/scene/scene_loader.h"
#include "tests/shared/scene/scene_file.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

constexpr const char* kMembrane = "{membrane: {radius: 39 mm, thickness: 1 mm}}";
constexpr const char* kBox = "{box: {size: [60 mm, 40 mm, 20 mm], cells: [3, 2, 1]}}";
constexpr const char* kPair = "{source: simulated, pair: {}}";

struct Lines {
  std::string camera = kPair;
  std::string points = "{}";
  std::string geometry = kMembrane;
  std::string fixed = "{side: rim}";
  std::string model = "{kind: plate-large}";
  std::string more;
  std::string tool = "{shape: flat, width: 4 mm}";
};

std::string StereoScene(const Lines& lines) {
  return "name: eyes\n"  // 1
         "object:\n"     // 2
         "  geometry: " +
         lines.geometry +                                                             // 3
         "\n  material: {young_modulus: 27.2 MPa, poisson_ratio: 0.45}\n" +           // 4
         (lines.fixed.empty() ? "  pose: {}\n" : "  fixed: " + lines.fixed + "\n") +  // 5
         "model: " + lines.model +                                                    // 6
         "\ntool: " + lines.tool +                                                    // 7
         "\n"
         "sense:\n"  // 8
         "  camera: " +
         lines.camera +                          // 9
         "\n  points: " + lines.points + "\n" +  // 10
         lines.more;                             // 11
}

// A rig's file as far as a scene looks into it.
std::string RigText(const std::string& cameras) {
  std::string text = "%YAML:1.0\n---\n";
  for (const char camera : cameras) {
    text += std::string(camera == 'l' ? "left" : "right") +
            ":\n   image_width: 640\n   image_height: 480\n"
            "   camera_matrix: !!opencv-matrix\n      rows: 3\n      cols: 3\n      dt: d\n"
            "      data: [ 800., 0., 319.5, 0., 800., 239.5, 0., 0., 1. ]\n";
  }
  return text + "rms_px: 0.2\n";
}

// With the files that the scenes below name.
class StereoSceneTest : public ::testing::Test {
 protected:
  StereoSceneTest() {
    std::filesystem::create_directory(folder_.path() / "pairs");
    std::filesystem::create_directory(folder_.path() / "empty");
    for (const char* name : {"left_00.png", "left_01.png", "right_00.png", "right_01.png"}) {
      folder_.Write(std::string("pairs/") + name, "");
    }
    folder_.Write("rig.yaml", RigText("lr"));
    folder_.Write("left.yaml", RigText("l"));
    folder_.Write("right.yaml", RigText("r"));
    folder_.Write("broken.yaml", "left: [\n");
    folder_.Write("dots.csv", "x,y\n0,0\n0.01,0\n0,0.01\n-0.012,0\n");
    folder_.Write("close.csv", "0,0\n0.01,0\n0,0.001\n");
    folder_.Write("wide.csv", "0,0\n0.01,0\n0,0.0385\n");
    folder_.Write("words.csv", "0,0\n0.01,zero\n");
  }
  Scene Load(const Lines& lines, SceneUse use = SceneUse::kFull) const {
    return LoadScene(folder_.Write("scene.yaml", StereoScene(lines)), {}, use);
  }
  std::string MistakesOf(const Lines& lines, SceneUse use = SceneUse::kFull) const {
    try {
      Load(lines, use);
      return {};
    } catch (const SceneError& error) {
      return error.what();
    }
  }
  SceneFolder folder_;
};

constexpr const char* kFiles =
    "{stereo: {left: \"pairs/left_%02d.png\", right: \"pairs/right*.png\", rig: rig.yaml}, rate: "
    "20 "
    "Hz, pose: {translation: [1 mm, 2 mm, -250 mm], rotation: [0, 0, 90 deg]}}";

TEST_F(StereoSceneTest, ThePairHasTheStatedRigByDefault) {
  const Scene scene = Load({});
  const StereoCameras& pair = scene.sense.stereo.value();
  EXPECT_EQ(pair.source, StereoCameras::Source::kSimulated);
  EXPECT_EQ(pair.size, (std::array{640, 480}));
  EXPECT_EQ(pair.focal, 800);
  EXPECT_DOUBLE_EQ(pair.baseline, 0.06);
  EXPECT_EQ(pair.rate, 30);
  EXPECT_TRUE(pair.rig.empty());
  EXPECT_FALSE(scene.sense.camera || scene.sense.depth || scene.sense.tip || scene.sense.contour);
  EXPECT_TRUE(HasEyes(scene.sense) && HasPictures(scene.sense));
  EXPECT_EQ(SensorRate(scene.sense), 30);
  EXPECT_TRUE(scene.model.prestress == 0 && scene.site.pace == 1);
}

// Reference: paper C, 5.1: about 250 mm from the membrane; the left camera is half the baseline to
// the left of the axis, and both look at the middle, so that O lies on the optical axis.
TEST_F(StereoSceneTest, ThePairStandsInsideAndLooksAtTheMembranesCentreWhereverItIs) {
  Lines lines;
  lines.camera =
      "{source: simulated, rate: 60 Hz, size: [800, 600], pair: {baseline: 100 mm, "
      "focal: 900 px}}";
  lines.fixed += "\n  pose: {translation: [10 mm, -20 mm, 5 mm], rotation: [0, 90 deg, 30 deg]}";
  const Scene scene = Load(lines);
  const StereoCameras& pair = *scene.sense.stereo;
  EXPECT_EQ(pair.rate, 60);
  EXPECT_EQ(pair.size, (std::array{800, 600}));
  EXPECT_EQ(pair.focal, 900);
  EXPECT_DOUBLE_EQ(pair.baseline, 0.1);
  const Eigen::Isometry3d X_OL = scene.object.X_SO.inverse() * pair.X_SL;
  EXPECT_LT((X_OL.translation() - Eigen::Vector3d(-0.05, 0, -0.25)).norm(), 1e-15);
  const Eigen::Vector3d p_L = X_OL.inverse() * Eigen::Vector3d::Zero();
  EXPECT_LT(p_L.head<2>().norm(), 1e-15);
  EXPECT_NEAR(p_L.z(), std::hypot(0.05, 0.25), 1e-15);
  EXPECT_GT(X_OL.linear()(0, 0), 0.9);           // x of L along x of O
  EXPECT_NEAR(X_OL.linear()(1, 1), 1.0, 1e-15);  // y, too
}

TEST_F(StereoSceneTest, APoseReplacesTheDefaultOne) {
  Lines lines;
  lines.camera = "{source: simulated, pair: {}, pose: {translation: [0, 0, -300 mm]}}";
  const Eigen::Isometry3d X_SL = Load(lines).sense.stereo->X_SL;
  EXPECT_TRUE(X_SL.linear().isIdentity());
  EXPECT_TRUE(X_SL.translation().isApprox(Eigen::Vector3d(0, 0, -0.3)));
}

TEST_F(StereoSceneTest, FilesOfTwoCamerasAreRead) {
  Lines lines;
  lines.camera = kFiles;
  const StereoCameras pair = Load(lines).sense.stereo.value();
  EXPECT_EQ(pair.source, StereoCameras::Source::kFiles);
  EXPECT_EQ(pair.left, (folder_.path() / "pairs/left_%02d.png").string());
  EXPECT_EQ(pair.right, (folder_.path() / "pairs/right*.png").string());
  EXPECT_EQ(pair.rig, folder_.path() / "rig.yaml");
  EXPECT_EQ(pair.rate, 20);
  EXPECT_TRUE(pair.X_SL.translation().isApprox(Eigen::Vector3d(0.001, 0.002, -0.25)));
  EXPECT_TRUE((pair.X_SL.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
}

// The scene's name may come without a folder, and so may the pictures'.
TEST_F(StereoSceneTest, PatternsAreFoundFromTheWorkingDirectory) {
  folder_.Write("l1.png", "");
  folder_.Write("r1.png", "");
  Lines lines;
  lines.camera =
      "{stereo: {left: \"l*.png\", right: \"r%d.png\", rig: rig.yaml}, pose: {translation: [0, 0, "
      "-1]}}";
  folder_.Write("scene.yaml", StereoScene(lines));
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  EXPECT_EQ(LoadScene("scene.yaml").sense.stereo.value().left, "l*.png");
  std::filesystem::current_path(before);
}

TEST_F(StereoSceneTest, DepthPicturesAreReadAndShowTheSurface) {
  Lines lines;
  lines.camera =
      "{depth: pairs, unit: 0.1 mm, fx: 600 px, fy: 601, cx: 320.5, cy: 240 px, sigma: "
      "0.3 mm, pose: {translation: [0, 0, -200 mm]}}";
  const Scene scene = Load(lines);
  const DepthPictures& depth = scene.sense.depth.value();
  EXPECT_EQ(depth.pattern, (folder_.path() / "pairs").string());
  EXPECT_DOUBLE_EQ(depth.unit, 1e-4);
  EXPECT_EQ(depth.fx, 600);
  EXPECT_EQ(depth.fy, 601);
  EXPECT_EQ(depth.cx, 320.5);
  EXPECT_EQ(depth.cy, 240);
  EXPECT_DOUBLE_EQ(depth.sigma, 3e-4);
  EXPECT_EQ(depth.rate, 30);
  EXPECT_TRUE(depth.X_SD.translation().isApprox(Eigen::Vector3d(0, 0, -0.2)));
  EXPECT_EQ(scene.sense.points.value().track, PointTracking::Track::kSurface);
  EXPECT_FALSE(scene.sense.stereo);
}

// Reference: paper C, 5.1: 31 dots, 15 mm and 10 mm apart, on 39 mm.
TEST_F(StereoSceneTest, AMembraneHasThePapersDotsByDefault) {
  const PointTracking points = Load({}).sense.points.value();
  EXPECT_EQ(points.track, PointTracking::Track::kDots);
  EXPECT_EQ(points.count, 31);
  EXPECT_TRUE(points.spacing.isApprox(Eigen::Vector2d(0.015, 0.010)));
  EXPECT_DOUBLE_EQ(points.dot_radius, 0.002);
  EXPECT_DOUBLE_EQ(points.sigma, 0.1);
  EXPECT_TRUE(points.layout.empty() && points.at.empty());
}

// Any count fits, on a membrane of any size, without a word about spacing.
TEST_F(StereoSceneTest, AnyNumberOfDotsFitsByDefault) {
  for (const int count : {4, 5, 7, 13, 31, 32, 37, 45, 49, 100, 399, 400}) {
    for (const auto& [radius, width] :
         {std::pair("3 mm", "1 mm"), std::pair("38 mm", "4 mm"), std::pair("2 m", "60 mm")}) {
      Lines lines;
      const std::string thickness = std::string(radius) == "2 m" ? "5 mm" : "0.1 mm";
      lines.geometry =
          std::string("{membrane: {radius: ") + radius + ", thickness: " + thickness + "}}";
      lines.tool = std::string("{shape: flat, width: ") + width + "}";
      lines.points = "{count: " + std::to_string(count) + "}";
      EXPECT_EQ(MistakesOf(lines), "") << count << " on " << radius;
    }
  }
}

TEST_F(StereoSceneTest, EveryKeyOfDotsIsRead) {
  Lines lines;
  lines.points = "{track: dots, count: 12, spacing: [9 mm, 8 mm], radius: 1.5 mm, sigma: 0.2 px}";
  const PointTracking points = *Load(lines).sense.points;
  EXPECT_EQ(points.count, 12);
  EXPECT_TRUE(points.spacing.isApprox(Eigen::Vector2d(0.009, 0.008)));
  EXPECT_DOUBLE_EQ(points.dot_radius, 0.0015);
  EXPECT_DOUBLE_EQ(points.sigma, 0.2);
}

TEST_F(StereoSceneTest, ALayoutSaysHowManyDotsThereAre) {
  Lines lines;
  lines.points = "{layout: dots.csv}";
  const PointTracking points = *Load(lines).sense.points;
  EXPECT_EQ(points.layout, folder_.path() / "dots.csv");
  EXPECT_EQ(points.count, 4);
  EXPECT_DOUBLE_EQ(points.dot_radius, 0.002);  // a fifth of 10 mm
}

TEST_F(StereoSceneTest, WindowsOfTextureAreRead) {
  Lines lines;
  lines.camera = kFiles;
  lines.points = "{track: texture, at: [[15, 15], [624, 464 px]], window: 31 px, sigma: 0.3 px}";
  const PointTracking points = *Load(lines).sense.points;
  EXPECT_EQ(points.track, PointTracking::Track::kTexture);
  ASSERT_EQ(points.at.size(), 2U);
  EXPECT_EQ(points.at[1], Eigen::Vector2d(624, 464));
  EXPECT_EQ(points.count, 2);
  EXPECT_EQ(points.window, 31);
  lines.points = "{track: texture, count: 1, window: 255}";
  EXPECT_EQ(Load(lines).sense.points->count, 1);
}

TEST_F(StereoSceneTest, AMembranesTextureMayBeFollowed) {
  Lines lines;
  lines.points = "{track: texture, count: 40}";
  const PointTracking points = *Load(lines).sense.points;
  EXPECT_EQ(points.track, PointTracking::Track::kTexture);
  EXPECT_EQ(points.count, 40);
}

// What nothing holds is followed; no force is told, so no camera's place need be known.
TEST_F(StereoSceneTest, WhatNothingHoldsIsFollowedByItsTexture) {
  Lines lines;
  lines.geometry = kBox;
  lines.fixed = "";
  lines.model = "{kind: auto}";
  const Scene simulated = Load(lines);
  EXPECT_EQ(simulated.sense.points->track, PointTracking::Track::kTexture);
  EXPECT_FALSE(IsHeld(simulated.object));
  lines.camera =
      "{stereo: {left: \"pairs/left_%02d.png\", right: \"pairs/right*.png\", rig: rig.yaml}}";
  EXPECT_TRUE(Load(lines).sense.stereo->X_SL.isApprox(Eigen::Isometry3d::Identity()));
  lines.fixed = "{plane: {axis: z, at: 0 m}}";
  EXPECT_THAT(MistakesOf(lines), HasSubstr(":9: sense.camera.pose = (missing): accepted is a map"));
}

// Reference: sections.h; the press goes along -z of O from outside, with a clearance of 7 % of the
// diameter, in a workspace larger than the membrane's box by its diameter.
TEST_F(StereoSceneTest, TheHandBeginsBeforeTheMembranesCentre) {
  const Scene flat = Load({});
  EXPECT_LT((flat.manipulator.home - Eigen::Vector3d(0, 0, 0.07 * 0.078)).norm(), 1e-15);
  EXPECT_TRUE(flat.manipulator.workspace_min.isApprox(Eigen::Vector3d(-0.117, -0.117, -0.0785)));
  EXPECT_TRUE(flat.manipulator.workspace_max.isApprox(Eigen::Vector3d(0.117, 0.117, 0.0785)));
  EXPECT_DOUBLE_EQ(flat.operator_options.press_depth, 0.055 * 0.078);
  Lines lines;
  lines.fixed += "\n  pose: {translation: [0, 0, 100 mm], rotation: [45 deg, 0, 0]}";
  const Scene tilted = Load(lines);
  const Eigen::Vector3d p_O = tilted.object.X_SO.inverse() * tilted.manipulator.home;
  EXPECT_LT(p_O.head<2>().norm(), 1e-15);
  EXPECT_GT(p_O.z(), 0.004);
}

TEST_F(StereoSceneTest, AToolThatIsNotNamedIsAFifteenthOfTheObject) {
  std::string text = StereoScene({});
  text.erase(text.find("tool: "), text.find("sense:") - text.find("tool: "));
  const Scene scene = LoadScene(folder_.Write("scene.yaml", text));
  EXPECT_DOUBLE_EQ(scene.tool.value().width, 0.078 / 15);
}

TEST_F(StereoSceneTest, TensionAtRestAndPaceAreRead) {
  Lines lines;
  lines.model = "{kind: plate-large, prestress: 12 N/m}";
  lines.more = "site: {pace: 3}\n";
  EXPECT_DOUBLE_EQ(Load(lines).model.prestress, 12);
  EXPECT_DOUBLE_EQ(Load(lines).site.pace, 3);
  lines.model = "{prestress: 1.5 N/mm}";
  EXPECT_DOUBLE_EQ(Load(lines).model.prestress, 1500);
  lines.model = "{prestress: 5 mN/m}";
  EXPECT_DOUBLE_EQ(Load(lines).model.prestress, 0.005);
}

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
  EXPECT_THAT(with([](Lines& l) { l.more = "manipulator: {home: [0, 30 mm, 5 mm]}\n"; }),
              HasSubstr(":11: manipulator.home = [0, 30 mm, 5 mm]: accepted is a place before"));
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

// `solve` and `study` take the scene where neither pictures nor rig are at hand.
TEST_F(StereoSceneTest, TheModelAloneNeedsNoFiles) {
  Lines lines;
  lines.camera = "{stereo: {left: \"no/%d.png\", right: \"no*.png\"}}";
  EXPECT_EQ(MistakesOf(lines, SceneUse::kSolve), "");
  EXPECT_NE(MistakesOf(lines), "");
}

// What moves as a whole before the cameras may be held for the model alone.
TEST_F(StereoSceneTest, ATargetMayBeHeldToBeSolved) {
  Lines lines;
  lines.geometry = kBox;
  lines.fixed = "{plane: {axis: z, at: 0 m}}";
  lines.model = "{kind: fem}";
  EXPECT_EQ(MistakesOf(lines, SceneUse::kSolve), "");
  EXPECT_THAT(MistakesOf(lines), HasSubstr(":5: object.fixed = "));
}

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
     "9: sense.camera.pose = {translation: [0, 0, 250 mm]}: accepted is one that has the object's "
     "origin before the camera"},
    {"DepthFromBehind",
     Camera("{depth: pairs, fx: 1, fy: 1, cx: 1, cy: 1, pose: {translation: [0, 0, 0]}}"),
     "9: sense.camera.pose = {translation: [0, 0, 0]}: accepted is one that has the object's"},
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
     "9: sense.camera.pair = {}: accepted is nothing beside `file`"},
    {"PairBesideStereo",
     Camera("{stereo: {left: pairs, right: pairs, rig: rig.yaml}, pair: {}, pose: {translation: "
            "[0, 0, 0]}}"),
     "9: sense.camera.pair = {}: accepted is nothing beside `stereo`"},
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
     "9: sense.camera.stereo.left = pairs/none*.png: accepted is a pattern that names a file"},
    {"EmptyPattern", Files("pairs", "empty/%04d.png", "rig.yaml"),
     "9: sense.camera.stereo.right = empty/%04d.png: accepted is a pattern that names a file"},
    {"NoSuchFolder", Files("nowhere/*.png", "pairs", "rig.yaml"),
     "9: sense.camera.stereo.left = nowhere/*.png: accepted is a pattern that names a file"},
    {"EvilPattern", Files("pairs/%s%n.png", "pairs", "rig.yaml"),
     "9: sense.camera.stereo.left = pairs/%s%n.png: accepted is one number like %d"},
    {"FolderAsPattern", Files("pairs%d/left.png", "pairs", "rig.yaml"),
     "9: sense.camera.stereo.left = pairs%d/left.png: accepted is one number like %d"},
    {"NoRig", Files("pairs", "pairs", ""),
     "9: sense.camera.stereo.rig = (missing): accepted is a file that `calibrate` wrote"},
    {"RigMissing", Files("pairs", "pairs", "none.yaml"),
     "9: sense.camera.stereo.rig = none.yaml: accepted is a file that exists"},
    {"RigOfOneCamera", Files("pairs", "pairs", "left.yaml"),
     "9: sense.camera.stereo.rig = left.yaml: accepted is a rig of two cameras, as `calibrate "
     "--left ... --right ...` writes it; this one has no `right`"},
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
     "10: sense.points.track = surface: accepted is dots or texture with two cameras"},
    {"DotsOfASimulatedTarget", Volume(kPair, "{track: dots, layout: dots.csv}", ""),
     "10: sense.points.track = dots: accepted is texture: a simulated pair sees dots on a "
     "membrane"},
    {"DotsInDepth", PointsInDepth("{track: dots}"),
     "10: sense.points.track = dots: accepted is surface with depth pictures"},
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
     "10: sense.points.layout = words.csv: accepted is a CSV file of places x,y [m]; "},
    {"LayoutAndCount", Points("{layout: dots.csv, count: 4}"),
     "10: sense.points.count = 4: accepted is nothing beside `layout`"},
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
     "10: sense.points.at = []: accepted is 1 to 10000 places"},
    {"AtOutside", PointsInFiles("{track: texture, at: [[300, 200], [640, 100]]}"),
     "10: sense.points.at = [[300, 200], [640, 100]]: accepted is places whose windows lie inside "
     "the picture of 640 x 480 px"},
    {"AtTheEdge", PointsInFiles("{track: texture, at: [[14, 100]]}"),
     "10: sense.points.at = [[14, 100]]: accepted is places whose windows lie inside"},
    {"AtInMillimetres", PointsInFiles("{track: texture, at: [[1 mm, 100]]}"),
     "10: sense.points.at.0.0 = 1 mm: accepted is a number of pixels"},
    {"AtAndCount", PointsInFiles("{track: texture, at: [[100, 100]], count: 1}"),
     "10: sense.points.count = 1: accepted is nothing beside `at`"},
    {"SpacingOfTexture", PointsInFiles("{track: texture, spacing: [1 mm, 1 mm]}"),
     "10: sense.points.spacing = [1 mm, 1 mm]: accepted is"},
};
INSTANTIATE_TEST_SUITE_P(Points, BadStereoSceneTest, ::testing::ValuesIn(kPoints),
                         [](const auto& row) { return std::string(row.param.name); });

const BadScene kRest[] = {
    {"TipBesideAPair", More("  tip: {track: template}\n"),
     "11: sense.tip = {track: template}: accepted is nothing beside a camera that sees in space"},
    {"ContourBesideAPair", More("  contour: {track: snake}\n"),
     "11: sense.contour = {track: snake}: accepted is nothing beside"},
    {"HomeInside", More("manipulator: {home: [0, 0, -5 mm]}\n"),
     "11: manipulator.home = [0, 0, -5 mm]: accepted is a place before the membrane"},
    {"NegativeTension", Model("{kind: plate-large, prestress: -1 N/m}"),
     "6: model.prestress = -1 N/m: accepted is a tension in N/m mN/m N/mm, >= 0"},
    {"TensionIsAPressure", Model("{kind: plate-large, prestress: 12 Pa}"),
     "6: model.prestress = 12 Pa: accepted is a tension"},
    {"TensionOfAPlate", Model("{kind: plate, prestress: 12 N/m}"),
     "6: model.prestress = 12 N/m: accepted is nothing with this kind: plate-large"},
    {"TensionOfABox",
     {"{stereo: {left: pairs, right: pairs, rig: rig.yaml}, pose: {translation: [0, 0, -1]}}",
      "{}",
      kBox,
      "{plane: {axis: z, at: 0 m}}",
      "{prestress: 1}",
      {}},
     "6: model.prestress = 1: accepted is nothing here: a membrane alone"},
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
     "5: object.fixed = {plane: {axis: z, at: 0 m}}: accepted is nothing where a textured target"},
    {"DotsOfABox", Volume(kFiles, "{track: dots}", "{plane: {axis: z, at: 0 m}}"),
     "10: sense.points.track = dots: accepted is texture, or dots with their `layout`"},
    {"DepthOfWhatIsNotHeld",
     Volume("{depth: pairs, fx: 1, fy: 1, cx: 1, cy: 1, pose: {translation: [0, 0, -1]}}", "{}",
            ""),
     "2: object.fixed = (missing): accepted is where the object is held"},
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
  try {
    LoadScene(folder_.Write("scene.yaml", text));
    FAIL() << "fingertips see no dots";
  } catch (const SceneError& error) {
    EXPECT_THAT(error.what(), HasSubstr(":7: sense.points = {track: dots}: accepted is nothing "
                                        "beside `tactile`"));
  }
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
