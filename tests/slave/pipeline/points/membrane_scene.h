// Paper C's rubber membrane for tests, and the motion of its dots.
#pragma once

#include <random>

#include "slave/mechanics/plate/plate_surface.h"
#include "slave/scene/scene.h"
#include "slave/vision/dots/dot_layout.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate::testing_fakes {

inline constexpr double kRadius = 0.039, kThickness = 0.001, kModulus = 27.2e6, kNu = 0.45;
inline constexpr double kToolWidth = 0.004;

inline Scene MembraneScene(const std::string& kind) {
  Scene scene;
  scene.name = "membrane";
  scene.object.geometry = MembraneGeometry{kRadius, kThickness};
  scene.object.material.young_modulus = kModulus;
  scene.object.material.poisson_ratio = kNu;
  scene.tool = Tool{.shape = Tool::Shape::kRound, .width = kToolWidth};
  scene.model.kind = kind;
  return scene;
}

// `plate` under a force [N] of the tool along z at p_O.
inline Solution Loaded(PlateSurface& plate, const Eigen::Vector2d& p_O, double force) {
  const Contact load = PlateSurface::ToolContact(Contact::Kind::kForce, p_O, {kToolWidth}, force);
  Solution solution;
  plate.Solve({&load, 1}, &solution);
  return solution;
}

// The 31 dots of the paper, displaced along z as `plate` is under a force [N] along z at p_O, with
// noise of `sigma` [m] per axis; frame S is that of `X_SO`.
inline SurfaceObservation DotsUnder(PlateSurface& plate, const Eigen::Vector2d& p_O, double force,
                                    double sigma, std::mt19937* random,
                                    const Eigen::Isometry3d& X_SO = Eigen::Isometry3d::Identity()) {
  const Solution solution = Loaded(plate, p_O, force);
  std::normal_distribution<double> normal(0, sigma);
  SurfaceObservation seen;
  seen.sequence = 1;
  seen.found = true;
  for (const Eigen::Vector2d& dot : LatticePlaces(31, {0.015, 0.010})) {
    Eigen::Vector3d moved(0, 0, force == 0 ? 0 : plate.Displacement(solution, dot));
    if (random != nullptr) {
      const double z = normal(*random), y = normal(*random);  // in this order with every compiler
      moved += Eigen::Vector3d(normal(*random), y, z);
    }
    const Eigen::Vector3d rest(dot.x(), dot.y(), 0);
    seen.points.push_back({.id = static_cast<int>(seen.points.size()),
                           .seen = true,
                           .p_S_rest = X_SO * rest,
                           .p_S = X_SO * Eigen::Vector3d(rest + moved),
                           .covariance = sigma * sigma * Eigen::Matrix3d::Identity()});
  }
  return seen;
}

}  // namespace palpate::testing_fakes
