// Scenes with two cameras for the tests, made in memory: the membrane and the rig of paper C's
// second device as the shipped scenes state them.
#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/scene/scene.h"

namespace palpate::site {

// The pair 250 mm inside, looking at O's origin, 60 mm apart along x.
inline Eigen::Isometry3d LeftEye(const Eigen::Isometry3d& X_SO, double baseline = 0.06) {
  return X_SO * Eigen::Translation3d(-baseline / 2, 0, -0.25) *
         Eigen::AngleAxisd(std::atan2(baseline / 2, 0.25), Eigen::Vector3d::UnitY());
}

// What these tests claim holds on any mesh.
inline constexpr MembraneResolution kCoarse{4, 1};

inline Scene MembraneScene() {
  Scene scene;
  scene.name = "membrane";
  scene.object.geometry = MembraneGeometry{0.039, 0.001};
  scene.object.material.young_modulus = 27.2e6;
  scene.object.material.poisson_ratio = 0.45;
  scene.object.X_SO.translation() << 0.1, -0.02, 0.03;
  scene.tool = Tool{.shape = Tool::Shape::kRound, .width = 4e-3};
  scene.sense.Set(PointsOptions{StereoCameras{.X_SL = LeftEye(scene.object.X_SO)}, {}});
  scene.operator_options.press_depth = 5e-3;
  scene.manipulator.home = scene.object.X_SO * Eigen::Vector3d(0, 0, 5e-3);
  return scene;
}

inline Scene WithoutFlaws(Scene scene) {
  scene.site.noise = scene.site.blur = scene.site.lighting = scene.site.flicker = 0;
  return scene;
}

inline Scene TargetScene() {
  Scene scene = MembraneScene();
  scene.name = "target";
  scene.object.geometry = BoxGeometry{{0.04, 0.04, 0.04}, {1, 1, 1}};
  scene.sense.Find<PointTracking>()->track = PointTracking::Track::kTexture;
  return scene;
}

}  // namespace palpate::site
