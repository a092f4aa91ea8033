// Scenes with fingertips for the tests, made in memory: the foam objects of paper B (tables II and
// III, hard).
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "slave/scene/scene.h"

namespace palpate::simulation {

// Returns a fingertip whose pad faces along `pad_S`, with its axis as close as possible to `axis_S`
// and the centre of its tip at `centre_S`.
inline Finger FingerAt(const std::string& name, const Eigen::Vector3d& centre_S,
                       const Eigen::Vector3d& pad_S, const Eigen::Vector3d& axis_S) {
  Finger finger;
  finger.name = name;
  Eigen::Matrix3d R;
  R.col(2) = -pad_S.normalized();
  R.col(0) = (axis_S - axis_S.dot(R.col(2)) * R.col(2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  finger.X_SF.linear() = R;
  finger.X_SF.translation() = centre_S;
  return finger;
}

inline Scene FoamScene(const Eigen::Vector3d& size, const Fixed& fixed) {
  Scene scene;
  scene.name = "foam";
  scene.object.geometry = BoxGeometry{size, {2, 2, 2}};
  scene.object.material = {.young_modulus = 3800, .poisson_ratio = 0.15, .density = 45};
  scene.object.fixed = {fixed};
  scene.sense.Set(Tactile{.source = Tactile::Source::kSimulated});
  scene.operator_options.press_depth = 2e-3;
  scene.operator_options.press_speed = 0.02;
  scene.manipulator.max_speed = 0.05;
  return scene;
}

// The cube lies on the table; a fingertip is 5 mm above its centre, with the tip 40 degrees down.
inline Scene CubeScene() {
  Scene scene = FoamScene({0.06, 0.06, 0.06}, {FixedPlane{2, 0}});
  scene.sense.Find<Tactile>()->fingers = {
      FingerAt("ff", {0.03, 0.03, 0.072}, {-0.64, 0, -0.77}, {1, 0, -1})};
  return scene;
}

// The cube is fixed at x = 0 and pinched by two fingers whose pads face each other, 5 mm from it.
inline Scene PinchScene() {
  Scene scene = FoamScene({0.06, 0.06, 0.06}, {FixedPlane{0, 0}});
  auto& fingers = scene.sense.Find<Tactile>()->fingers;
  fingers = {FingerAt("ff", {0.03, 0.072, 0.03}, {0, -1, 0}, {-1, 0, 0}),
             FingerAt("th", {0.03, -0.012, 0.03}, {0, 1, 0}, {-1, 0, 0})};
  fingers[1].motion = Finger::Motion::kOpposite;
  return scene;
}

}  // namespace palpate::simulation
