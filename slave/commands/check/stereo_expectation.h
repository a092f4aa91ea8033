// Expected accuracy of a stereo pair for an object at rest, before an image is taken.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "shared/state/validity.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// One sigma of a point at the origin of O, from points.sigma in each image.
struct SightExpectation {
  double distance = 0;  // from the midpoint between the cameras [m]
  double sigma_depth =
      0;  // sigma along the line of sight [m], approximately z^2 / (f b) sqrt(2) sigma
  double sigma_across = 0;  // the larger across it [m]
};
// nullopt: the origin is not in front of both cameras.
std::optional<SightExpectation> ExpectedSight(const Scene& scene, const StereoRig& rig);

// Returns the positions (x, y of O at z = 0 [m]) that are in both images, at least a dot's radius
// from the edge.
std::vector<Eigen::Vector2d> InBothImages(const Scene& scene, const StereoRig& rig,
                                          const std::vector<Eigen::Vector2d>& places_O);

// The force that the displacements at the positions determine for the scene's contact below home.
struct ForceExpectation {
  double force = 0;  // its size [N]
  double sigma = 0;  // from the sigmas of the positions; the model's error is not included [N]
  Validity validity = Validity::kFailed;  // kFailed: the positions do not determine it
};
// Solves the contact with the scene's model and fits the force to the displacements at the
// positions, all of which are visible. nullopt: no membrane, or home is not above it. Throws
// std::invalid_argument: no model.
std::optional<ForceExpectation> ExpectedForce(const Scene& scene, const StereoRig& rig,
                                              const std::vector<Eigen::Vector2d>& places_O);

}  // namespace palpate
