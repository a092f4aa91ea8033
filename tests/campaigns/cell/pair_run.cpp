// A press that two cameras see, or a depth camera.
#include <cstdint>
#include <random>
#include <utility>
#include <variant>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "slave/simulator/points/stereo_site.h"
#include "slave/vision/dots/dot_layout.h"
#include "slave/vision/stereo/pair_rig.h"
#include "slave/vision/stereo/rig.h"
#include "tests/campaigns/cell/run.h"
#include "tests/support/normal_noise.h"

namespace palpate::campaign {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The two cameras of a scene.
struct CameraPair {
  StereoRig rig;
  Isometry3d X_SL;

  [[nodiscard]] const Lens& lens(int side) const { return side == 0 ? rig.left : rig.right; }
  // S -> the camera of this side.
  [[nodiscard]] Isometry3d ToCamera(int side) const {
    return side == 0 ? X_SL.inverse() : rig.X_RL * X_SL.inverse();
  }
  [[nodiscard]] Vector2d ImageOf(int side, const Vector3d& p_S, const Vector2d& otherwise) const {
    return Project(lens(side), ToCamera(side) * p_S).value_or(otherwise);
  }
};

// Lens (without distortion) and pose of each camera, and the places of the dots in its images.
nlohmann::json SpaceOf(const Scene& scene, const CameraPair& cameras) {
  nlohmann::json space;
  for (const int side : {0, 1}) {
    const Lens& lens = cameras.lens(side);
    const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> X_CS =
        cameras.ToCamera(side).matrix().topRows<3>();
    nlohmann::json dots = nlohmann::json::array();
    for (const Vector2d& p_O : DotPlaces(*scene.sense.Find<PointTracking>())) {
      const Vector2d at = cameras.ImageOf(side, scene.object.X_SO * Vector3d(p_O.x(), p_O.y(), 0),
                                          Vector2d(-100, -100));
      dots.push_back({at.x(), at.y()});
    }
    space.push_back({{"lens", {lens.fx, lens.fy, lens.cx, lens.cy}},
                     {"X_CS", std::vector<double>(X_CS.data(), X_CS.data() + X_CS.size())},
                     {"dots", std::move(dots)}});
  }
  return {{"cameras", std::move(space)},
          {"radius", std::get<MembraneGeometry>(scene.object.geometry).radius}};
}

constexpr double kDistance = 0.25;  // of the depth camera in front of the membrane [m]
constexpr int kWidth = 320, kHeight = 240;

// The image of a depth camera of the membrane's inner side, from the true surface.
cv::Mat DepthImage(const DepthImages& camera, const StereoSite& site, std::mt19937* random) {
  NormalNoise noise;
  cv::Mat image(kHeight, kWidth, CV_16U);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Vector2d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
      double z = kDistance;
      for (int k = 0; k < 2; ++k) z = kDistance + site.TrueDisplacement(z * ray).z();
      image.at<std::uint16_t>(y, x) =
          cv::saturate_cast<std::uint16_t>((z + camera.sigma * noise(*random)) / camera.unit);
    }
  }
  return image;
}

}  // namespace

Run RunOfPair(const Scene& scene, const Counts& counts) {
  const CameraPair cameras{SimulatedRig(scene), scene.sense.Find<StereoCameras>()->X_SL};
  Run run{scene, {}, kDistance / cameras.rig.left.fx, SpaceOf(scene, cameras)};
  const Isometry3d X_SO = TruePose(scene);
  const Vector3d home_O = X_SO.inverse() * scene.manipulator.home;
  const double depth = scene.operator_options.press_depth;
  const Vector3d pressed_S = X_SO * Vector3d(home_O.x(), home_O.y(), 0);
  std::array<View, 2> views;
  for (const int side : {0, 1}) {
    View& view = views[static_cast<std::size_t>(side)];
    view.tip = view.pressed = cameras.ImageOf(side, pressed_S, Vector2d(0, 0));
    view.width =
        scene.tool->width * cameras.lens(side).fx / (cameras.ToCamera(side) * pressed_S).z();
  }
  StereoSite site(scene);
  for (std::size_t i = 0; i < counts.all(); ++i) {
    const double z = home_O.z() - counts.WayAt(i) * (home_O.z() + depth);
    site.MoveTool(X_SO * Vector3d(home_O.x(), home_O.y(), z));
    StereoImages images = site.TakeImages();
    run.shots.push_back({images.left, images.right, {}, site.truth(), views});
  }
  return run;
}

Run RunOfDepth(const Scene& scene, const Counts& counts) {
  DepthImages camera;
  camera.unit = 0.02e-3;
  camera.sigma = 0.2e-3;
  camera.fx = camera.fy = 400;
  camera.cx = 0.5 * (kWidth - 1);
  camera.cy = 0.5 * (kHeight - 1);
  camera.X_SD.translation().z() = -kDistance;
  PointTracking points;
  points.track = PointTracking::Track::kSurface;
  Run run{scene, {}, kDistance / camera.fx, {}};
  run.scene.sense.Set(PointsOptions{camera, points});
  const double depth = scene.operator_options.press_depth;
  const Vector3d home = scene.manipulator.home;
  StereoSite site(scene);
  std::mt19937 random(scene.site.seed);
  View view;
  view.tip = view.pressed = {camera.cx, camera.cy};
  for (std::size_t i = 0; i < counts.all(); ++i) {
    site.MoveTool({home.x(), home.y(), home.z() - counts.WayAt(i) * (home.z() + depth)});
    run.shots.push_back({DepthImage(camera, site, &random), {}, {}, site.truth(), {view, view}});
  }
  return run;
}

}  // namespace palpate::campaign
