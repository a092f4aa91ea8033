// What two cameras may be expected to tell of an object at rest, before a picture is taken.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "shared/state/validity.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// One sigma of a point at the origin of O, from points.sigma in each picture.
struct SightExpectation {
  double distance = 0;      // from the middle between the cameras [m]
  double sigma_depth = 0;   // along the line of sight [m]; z^2 / (f b) sqrt(2) sigma, nearly
  double sigma_across = 0;  // the larger across it [m]
};
// nullopt: the origin is not in front of both cameras.
std::optional<SightExpectation> ExpectedSight(const Scene& scene, const StereoRig& rig);

// Those of the places (x, y of O at z = 0 [m]) that lie in both pictures, a dot's radius from the
// edge.
std::vector<Eigen::Vector2d> InBothPictures(const Scene& scene, const StereoRig& rig,
                                            const std::vector<Eigen::Vector2d>& places_O);

// The force that the places' displacements tell of the scene's press under home.
struct ForceExpectation {
  double force = 0;  // its size [N]
  double sigma = 0;  // from the places' sigmas alone: that of the model is not in it [N]
  Validity validity = Validity::kFailed;  // kFailed: the places do not tell it
};
// Solves the press by the scene's own model and fits it back from the displacements at the places,
// all of which are seen. nullopt: no membrane, or home is not over it. Throws
// std::invalid_argument: no model.
std::optional<ForceExpectation> ExpectedForce(const Scene& scene, const StereoRig& rig,
                                              const std::vector<Eigen::Vector2d>& places_O);

}  // namespace palpate
