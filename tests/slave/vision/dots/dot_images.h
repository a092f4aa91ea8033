// Images of discs with known positions: each pixel is covered by an ellipse with the exact fraction
// of thin scan lines; then blur, light and noise are applied.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/vision/stereo/rig.h"

namespace palpate {

// The inside is p' Q p < 0, p = (x, y, 1) [px]; positive far outside.
using Conic = Eigen::Matrix3d;

// Half axes `a`, `b` [px], the first turned by `angle` [rad].
Conic Ellipse(const Eigen::Vector2d& centre, double a, double b, double angle = 0);
// A disc seen through a lens without distortion: centre and unit normal in the camera's frame.
Conic DiscSeen(const Lens& lens, const Eigen::Vector3d& p_C, const Eigen::Vector3d& n_C,
               double radius);

struct DotImage {
  int width = 640, height = 480;
  double ground = 180, dot = 50;  // grey levels
  double blur = 0.7;              // sigma [px]
  double noise = 2;               // sigma [levels]
  double light_fall = 0;          // relative, from left to right
  std::vector<Conic> dots;
  // Half-planes of another grey level, n . p > offset; where several overlap, the last one counts.
  struct Beyond {
    Eigen::Vector2d n{1, 0};
    double offset = 0;
    double level = 0;
  };
  std::vector<Beyond> edges;

  [[nodiscard]] cv::Mat Render(std::uint64_t seed = 1) const;
};

// Discs of `radius` that lie flat on the surface at `places` [m] with the given normals, frame O,
// seen by the left (0) or the right camera of VergedRig(SceneLens()).
std::vector<Conic> ArraySeen(int eye, const std::vector<Eigen::Vector3d>& places,
                             const std::vector<Eigen::Vector3d>& normals, double radius);

}  // namespace palpate
