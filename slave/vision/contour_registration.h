// Registration of a known outline with the contour in the image at rest, and conversion of a
// contour to an outline.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/mesh/outline.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/observation.h"

namespace palpate {

struct OutlineFit {
  bool found = false;                                      // enough inliers, and a small correction
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();  // corrected pose of the object
  double rms_px = 0;       // distance of the inliers to the outline [px]
  int inliers = 0;         // of the contour's points
  double scale = 1;        // size of the contour relative to the outline [-]
  double scale_sigma = 0;  // one standard deviation; large if undetermined
  // Distance of the object's edge from the outline at any one point, one standard deviation [px]:
  // the part that neighbouring points share, which is shape, and the error of the fit. The
  // independent part of each point is noise and is not included.
  double sigma_px = 0;
};

// Fits `outline` (frame O, in the plane z = 0) to `contour_I` (points on the object's edge [px]):
// the rigid motion in the plane, near the scene's pose `X_SO`, that minimises the robust (Tukey)
// distances of the points to the outline, by Gauss-Newton on iteratively reweighted squares. Points
// near the tool or at rounded corners lose their weight. `reach` [px]: largest distance of the
// object from its pose in the scene. Beyond it, or with fewer than 40 % inliers, or with a rotation
// above 10 degrees, `found` is false and X_SO is the scene's. The scale is that of the best
// similarity; the motion has no scale.
OutlineFit FitOutline(const Outline& outline, const Eigen::Isometry3d& X_SO, CurveView contour_I,
                      const CameraView& view, double reach = 30);

// The contour [px] as a polygon in S [m], counter-clockwise.
std::vector<Eigen::Vector2d> ToSlave(CurveView contour_I, const CameraView& view);

}  // namespace palpate
