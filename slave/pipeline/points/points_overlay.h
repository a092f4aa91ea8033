// The points that the eyes follow and the load they tell, drawn into the left picture for a person.
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
  std::vector<Eigen::Vector2d> seen_I, lost_I;  // [px]; lost: where they were last seen
  double radius_px = 0;                         // of a point
  bool windows = false;                         // squares, not circles
  std::optional<Eigen::Vector2d> place_I;       // of the load, or of what is followed [px]
  std::optional<double> force;                  // its size [N]; nullopt: unknown
  double sigma = 0;                             // [N]
  Eigen::Vector2d along_I{0, 0};  // which way it points in the picture; 1 long across the sight
  std::string_view validity;
};

PointsOverlay MakePointsOverlay(const SurfacePointTracker& eyes, const SurfaceObservation& seen,
                                const ContactEstimate& felt);

// `image` as it is; depth (16 bit) stretched to 8-bit grey, black where there is none.
cv::Mat AsPicture(const cv::Mat& image);
// A copy of AsPicture(`image`) in colour with the points, the load's place, its force in numbers
// and, by its share of `full_scale` (the largest force that the hand can show, at the tool [N]), as
// an arrow and as a ring, since most of it points away from the cameras.
cv::Mat DrawPoints(const cv::Mat& image, const PointsOverlay& overlay, double full_scale);

}  // namespace palpate
