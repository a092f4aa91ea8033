// Draws the tracked points and the estimated load into the left image for display.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "shared/state/slave_state.h"
#include "slave/pipeline/points/surface_point_tracker.h"

namespace palpate {

struct PointsOverlay {
  std::vector<Eigen::Vector2d> seen_I, lost_I;  // [px]; lost: the last position
  double radius_px = 0;                         // of a point
  bool windows = false;                         // squares, not circles
  std::optional<Eigen::Vector2d> place_I;  // position of the load, or of the tracked object [px]
  std::optional<double> force;             // magnitude of the force [N]; nullopt: unknown
  double sigma = 0;                        // [N]
  Eigen::Vector2d along_I{0, 0};  // direction in the image; length 1 across the line of sight
  std::string_view validity;
};

PointsOverlay MakePointsOverlay(const SurfacePointTracker& tracker, const SurfaceObservation& seen,
                                const ContactEstimate& estimate);

// `image` unchanged; depth (16 bit) stretched to 8-bit grey, black without a measurement.
cv::Mat AsImage(const cv::Mat& image);
// Returns a copy of AsImage(`image`) in colour with the points, the position of the load and its
// force as a number. The force is also drawn relative to `full_scale` (the largest force that the
// device can render, at the tool [N]) as an arrow and as a ring, because most of it points away
// from the cameras; thin rings and marks across the arrow are one standard deviation apart from it.
cv::Mat DrawPoints(const cv::Mat& image, const PointsOverlay& overlay, double full_scale);

}  // namespace palpate
