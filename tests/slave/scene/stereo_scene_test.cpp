// Scenes of two cameras and of depth images: their keys and their defaults.
#include "tests/slave/scene/stereo_scene.h"

#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using ::testing::HasSubstr;

// Reference: paper C, 5.1: about 250 mm from the membrane; the left camera is half the baseline to
// the left of the axis, and both axes meet at the centre, so that O lies on the optical axis.
TEST_F(StereoSceneTest, ThePairIsInsideAndLooksAtTheMembranesCentreWhereverItIs) {
  SceneLines lines;
  lines.camera =
      "{source: simulated, rate: 60 Hz, size: [800, 600], pair: {baseline: 100 mm, "
      "focal: 900 px}}";
  lines.fixed += "\n  pose: {translation: [10 mm, -20 mm, 5 mm], rotation: [0, 90 deg, 30 deg]}";
  const Scene scene = Load(lines);
  const StereoCameras& pair = *scene.sense.Find<StereoCameras>();
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

TEST_F(StereoSceneTest, FilesOfTwoCamerasAreRead) {
  const StereoCameras pair = *Load({kFiles}).sense.Find<StereoCameras>();
  EXPECT_EQ(pair.source, StereoCameras::Source::kFiles);
  EXPECT_EQ(pair.left, (folder_.path() / "pairs/left_%02d.png").string());
  EXPECT_EQ(pair.right, (folder_.path() / "pairs/right*.png").string());
  EXPECT_EQ(pair.rig, folder_.path() / "rig.yaml");
  EXPECT_EQ(pair.rate, 20);
  EXPECT_TRUE(pair.X_SL.translation().isApprox(Eigen::Vector3d(0.001, 0.002, -0.25)));
  EXPECT_TRUE((pair.X_SL.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
}

TEST_F(StereoSceneTest, WhatIsNoLivePairIsReported) {
  const auto mistake = [&](const std::string& stereo) {
    return MistakesOf({"{stereo: " + stereo + ", pose: {translation: [0, 0, -1]}}"});
  };
  using testing::HasSubstr;
  EXPECT_THAT(mistake("{left: {device: 0, url: \"http://x\"}, right: {device: 1}, rig: rig.yaml}"),
              HasSubstr("expected exactly one of `device: NUMBER`, `file` (a video) and `url`"));
  EXPECT_THAT(mistake("{left: {url: nowhere}, right: {device: 1}, rig: rig.yaml}"),
              HasSubstr("expected an address such as rtsp://"));
  EXPECT_THAT(mistake("{left: {device: 0}, rig: rig.yaml}"), HasSubstr("stereo.right"));
  EXPECT_THAT(mistake("{device: 0, layout: top-bottom, rig: rig.yaml}"), HasSubstr("side-by-side"));
  EXPECT_THAT(mistake("{left: \"pairs/left_%02d.png\", right: \"pairs/right*.png\", sync: 5 ms, "
                      "rig: rig.yaml}"),
              HasSubstr("expected nothing with files"));
  EXPECT_THAT(mistake("{left: {device: 1}, right: {device: 1}, rig: rig.yaml}"),
              HasSubstr("stereo.right = {device: 1}: expected another camera than `left`"));
  EXPECT_EQ(mistake("{device: 0, layout: side-by-side, sync: 5 ms, rig: rig.yaml}"), "");
}

// By default OpenCV converts images to 8 bit, which is no depth image.
TEST_F(StereoSceneTest, WhatGivesNoDepthOf16BitIsReported) {
  const auto mistake = [&](const std::string& depth) {
    return MistakesOf({"{depth: " + depth +
                       ", fx: 600, fy: 600, cx: 320, cy: 240, pose: {translation: [0, 0, -1]}}"});
  };
  using testing::HasSubstr;
  EXPECT_THAT(mistake("{url: \"tcp://127.0.0.1:5000\"}"),
              HasSubstr("expected a GStreamer pipeline that ends in"));
  EXPECT_THAT(mistake("{url: \"v4l2src ! appsink\"}"), HasSubstr("format=GRAY16_LE"));
  EXPECT_THAT(mistake("{device: 0}"), HasSubstr("expected `url`, a GStreamer pipeline"));
  EXPECT_EQ(mistake("{url: \"v4l2src ! video/x-raw,format=GRAY16_LE ! appsink\"}"), "");
}

TEST_F(StereoSceneTest, DepthImagesAreReadAndShowTheSurface) {
  const Scene scene =
      Load({"{depth: pairs, unit: 0.1 mm, fx: 600 px, fy: 601, cx: 320.5, cy: 240 px, sigma: "
            "0.3 mm, pose: {translation: [0, 0, -200 mm]}}"});
  const DepthImages& depth = *scene.sense.Find<DepthImages>();
  EXPECT_EQ(depth.pattern, (folder_.path() / "pairs").string());
  EXPECT_DOUBLE_EQ(depth.unit, 1e-4);
  EXPECT_EQ(depth.fx, 600);
  EXPECT_EQ(depth.fy, 601);
  EXPECT_EQ(depth.cx, 320.5);
  EXPECT_EQ(depth.cy, 240);
  EXPECT_DOUBLE_EQ(depth.sigma, 3e-4);
  EXPECT_EQ(depth.rate, 30);
  EXPECT_TRUE(depth.X_SD.translation().isApprox(Eigen::Vector3d(0, 0, -0.2)));
  EXPECT_EQ(scene.sense.Find<PointTracking>()->track, PointTracking::Track::kSurface);
  EXPECT_FALSE(scene.sense.Find<StereoCameras>());
}

// Any count fits, on a membrane of any size, without a word about spacing.
TEST_F(StereoSceneTest, AnyNumberOfDotsFitsByDefault) {
  for (const int count : {4, 5, 7, 13, 31, 32, 37, 45, 49, 100, 399, 400}) {
    for (const auto& [radius, width] :
         {std::pair("3 mm", "1 mm"), std::pair("38 mm", "4 mm"), std::pair("2 m", "60 mm")}) {
      SceneLines lines;
      const std::string thickness = std::string(radius) == "2 m" ? "5 mm" : "0.1 mm";
      lines.geometry =
          std::string("{membrane: {radius: ") + radius + ", thickness: " + thickness + "}}";
      lines.tool = std::string("{shape: flat, width: ") + width + "}";
      lines.points = "{count: " + std::to_string(count) + "}";
      EXPECT_EQ(MistakesOf(lines), "") << count << " on " << radius;
    }
  }
}

// An object without supports is tracked. No force is reported, so the camera's pose need not be
// known.
TEST_F(StereoSceneTest, AnUnsupportedObjectIsTrackedByItsTexture) {
  SceneLines lines;
  lines.geometry = kBox;
  lines.fixed = "";
  lines.model = "{kind: auto}";
  const Scene simulated = Load(lines);
  EXPECT_EQ(simulated.sense.Find<PointTracking>()->track, PointTracking::Track::kTexture);
  EXPECT_FALSE(IsHeld(simulated.object));
  lines.camera =
      "{stereo: {left: \"pairs/left_%02d.png\", right: \"pairs/right*.png\", rig: rig.yaml}}";
  EXPECT_TRUE(
      Load(lines).sense.Find<StereoCameras>()->X_SL.isApprox(Eigen::Isometry3d::Identity()));
  lines.fixed = "{plane: {axis: z, at: 0 m}}";
  EXPECT_THAT(MistakesOf(lines), HasSubstr(":9: sense.camera.pose = (missing): expected a map"));
}

// Reference: sections.h; the press goes along -z of O from outside, with a clearance of 7 % of the
// diameter, in a workspace larger than the membrane's box by its diameter.
TEST_F(StereoSceneTest, TheHandBeginsBeforeTheMembranesCentre) {
  const Scene flat = Load({});
  EXPECT_LT((flat.manipulator.home - Eigen::Vector3d(0, 0, 0.07 * 0.078)).norm(), 1e-15);
  EXPECT_TRUE(flat.manipulator.workspace_min.isApprox(Eigen::Vector3d(-0.117, -0.117, -0.0785)));
  EXPECT_TRUE(flat.manipulator.workspace_max.isApprox(Eigen::Vector3d(0.117, 0.117, 0.0785)));
  EXPECT_DOUBLE_EQ(flat.operator_options.press_depth, 0.055 * 0.078);
  SceneLines lines;
  lines.fixed += "\n  pose: {translation: [0, 0, 100 mm], rotation: [45 deg, 0, 0]}";
  const Scene tilted = Load(lines);
  const Eigen::Vector3d p_O = tilted.object.X_SO.inverse() * tilted.manipulator.home;
  EXPECT_LT(p_O.head<2>().norm(), 1e-15);
  EXPECT_GT(p_O.z(), 0.004);
}

}  // namespace
}  // namespace palpate
