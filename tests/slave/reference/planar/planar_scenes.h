// Scenes of planar objects for the tests of their solutions and of the simulated camera, made in
// memory.
#pragma once

#include <limits>
#include <numbers>

#include "slave/scene/scene.h"

namespace palpate::simulation {

// Paper A's silicone block, pressed by its indenter at the centre of the top; the home is 3 mm
// above.
inline Scene BlockScene() {
  Scene scene;
  scene.name = "block";
  scene.object.geometry = RectangleGeometry{0.088, 0.088, 0.009};
  scene.object.material = {.young_modulus = 127e3, .poisson_ratio = 0.49};
  scene.object.fixed = {{FixedSide{"bottom"}}};
  scene.tool = Tool{.width = 0.088 / 15, .depth = std::numeric_limits<double>::infinity()};
  Camera camera;
  camera.pixel = 0.35e-3;
  camera.X_SC.translation() << 0.044, 0.060, 0;
  scene.sense.Set(CameraOptions{.camera = camera});
  scene.manipulator.home = {0.044, 0.091, 0};
  scene.manipulator.workspace_min = {-0.05, -0.05, 0};
  scene.manipulator.workspace_max = {0.15, 0.15, 0};
  return scene;
}

// A disc of an embryo's size, held on the left, pressed from the right by a thin pipette.
inline Scene EmbryoScene() {
  Scene scene;
  scene.name = "embryo";
  scene.object.geometry = DiscGeometry{0.6e-3, 1.2e-3};
  scene.object.material = {.young_modulus = 1.51e6, .poisson_ratio = 0.5};
  scene.object.fixed = {{FixedArc{std::numbers::pi, std::numbers::pi / 6}}};
  scene.model.plane = Plane::kStrain;
  scene.tool =
      Tool{.width = 40e-6, .depth = std::numeric_limits<double>::infinity(), .direction = {-1, 0}};
  scene.model.tolerance = 0.2;
  Camera camera;
  camera.pixel = 3e-6;
  scene.sense.Set(CameraOptions{.camera = camera});
  scene.manipulator.home = {0.7e-3, 0, 0};
  scene.manipulator.max_speed = 0.5e-3;
  scene.operator_options.press_depth = 100e-6;
  scene.operator_options.press_speed = 0.2e-3;
  return scene;
}

}  // namespace palpate::simulation
