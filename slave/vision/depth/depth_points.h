// Depth pictures as points of the surface: a grid of cells that keep their places in the picture.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "shared/scene/scene.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// Not thread-safe. Allocates in the first picture only.
class DepthPoints {
 public:
  struct Params {
    DepthPictures camera;              // intrinsics, unit, pose, sigma of one depth
    int cell = 16;                     // edge of a cell [px]
    int rest_pictures = 5;             // the rest frame is their mean
    double least_full = 0.5;           // share of a cell's pixels that must have a depth
    double nearest = 0, farthest = 1;  // along the ray's z [m]: what lies outside is no measurement
  };
  // Throws std::invalid_argument naming the parameter.
  explicit DepthPoints(const Params& params);

  // One picture: CV_16U, 0: no measurement. One point per cell, a robust mean of its depths, with
  // its covariance; a cell's identity is its place in the picture. `found` is false while the rest
  // frame is taken and for pictures that cannot be used. Valid until the next call.
  const SurfaceObservation& Observe(const cv::Mat& depth, std::uint64_t sequence,
                                    Time sensed_at) noexcept;
  [[nodiscard]] bool at_rest_known() const;

 private:
  Params params_;
  SurfaceObservation observation_;
};

}  // namespace palpate
