// Finds the object in the first image and checks it against the scene.
#pragma once

#include <memory>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/mesh/outline.h"
#include "slave/scene/scene.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/observation.h"

namespace palpate {

// Result of locating the rest surface in the first image.
struct Registration {
  bool measured = false;                                   // false: the scene's pose is used
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();  // pose in force
  double rms_px = 0;                    // of the contour points about the outline
  int points = 0;                       // number of points in the fit
  double sigma = 0;                     // standard deviation of the rest surface [m]
  std::shared_ptr<const Outline> seen;  // frame O; only for `contour: from-image`, else null
};

// Where the object may be: near the scene's pose, or anywhere in the image with a small rotation.
enum class ObjectPlace { kNearPose, kAnywhere };

// `contour_I`: the object's edge [px]; empty: the scene follows none. Throws std::runtime_error
// that names the scene's file: an outline that fits badly, or of another size than the scene's,
// which would make every force wrong.
Registration RegisterObject(const Scene& scene, CurveView contour_I, const CameraView& view,
                            ObjectPlace place = ObjectPlace::kNearPose);

}  // namespace palpate
