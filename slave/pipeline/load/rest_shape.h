// Whether a membrane that the scene calls flat is flat in the rest frame: one that is domed, or
// already pressed, answers a press otherwise than the plate does.
#pragma once

#include <vector>

#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// By the thickness: a shell so high is some percent stiffer than the plate. Half of it, as rms.
inline constexpr double kFlatHeight = 0.2;

// What is left of the points' places at rest beside a plane, frame O: how the plane lies is a
// matter of the camera's pose and changes no force.
struct RestShape {
  double height = 0, sigma_height = 0;  // of a dome h (1 - (r / a)^2)^2 about the centre [m]
  double rms = 0, sigma_rms = 0;        // of the points beside a plane, and of their noise [m]
  int points = 0;
};

// `radius` of the membrane about O's origin [m]. Fewer than six points: all zero. O(points).
RestShape RestShapeOf(const std::vector<SurfacePoint>& points_O, double radius) noexcept;

// Neither dome nor rest stands out of the noise by more than matters to a plate so thick [m].
bool IsFlat(const RestShape& shape, double thickness) noexcept;

}  // namespace palpate
