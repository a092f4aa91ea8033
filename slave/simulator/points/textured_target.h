// A rigid textured body, heart-like, on the path of paper C's second experiment: as test object of
// the texture tracker (paper C, 5.2, fig. 8).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/simulator/environment/painting.h"
#include "slave/vision/stereo/rig.h"

namespace palpate::simulation {

// (10 cos t, 10 sin t, 10 (cos t + sin t)) mm with t = `pace` x seconds: at most 17.3 mm/s with
// pace 1. (The paper says 50 mm/s: pace 3 has 52.)
Eigen::Vector3d HeartPath(double seconds, double pace);

// Half an ellipsoid with a smooth relief. Frame B: origin at the ellipsoid's centre, the textured
// half at negative z: with axes as a camera's, it faces that camera.
class TexturedTarget {
 public:
  struct Shape {
    Eigen::Vector3d semi_axes{0.034, 0.030, 0.020};  // [m]
    double relief = 0.0006;                          // height of the bumps [m]
    double grain = 1.2e-3;                           // of the texture [m]
    float grey = 120, contrast = 90;                 // levels
    std::uint32_t seed = 7;
  };
  explicit TexturedTarget(const Shape& shape);

  // Draws the body at X_CB onto `canvas` (CV_32F, the lens's size, with the background): point
  // samples of the texture without blur and noise. The facets of about a millimetre have exact
  // corners; within one, perspective bends the texture by less than 0.01 px at 250 mm.
  void Draw(const Lens& lens, const Eigen::Isometry3d& X_CB, cv::Mat& canvas) const;

  [[nodiscard]] const std::vector<Eigen::Vector3d>& vertices() const { return p_B_; }  // frame B
  [[nodiscard]] const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

 private:
  Texture texture_;
  std::vector<Eigen::Vector3d> p_B_;         // vertices [m]
  std::vector<Eigen::Vector2d> on_texture_;  // per vertex [texels]
  std::vector<std::array<int, 3>> triangles_;
};

}  // namespace palpate::simulation
