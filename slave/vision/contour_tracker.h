// Follows the object's outline from picture to picture, and measures it well where it rests.
#pragma once

#include <span>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/grey.h"
#include "slave/vision/snake.h"

namespace palpate {

class ContourTracker {
 public:
  // Finds the resting object in `first`: starts the snake at `options.start` (to be drawn within
  // some 10 px of the edge) or, with none, at what FindObject finds, lets it settle and refines it.
  // `tool_width` [px], 0: no tool. `clockwise_I`: which way round, as one sees the picture. Throws
  // std::runtime_error: no contour found, a picture too small, the contour collapsed, crossed
  // itself or found no edge.
  ContourTracker(const ContourTracking& options, const cv::Mat& first, const GreyFormat& format,
                 double tool_width, bool clockwise_I);

  // Control points in this picture [px]; empty where the contour has lost its edge, collapsed,
  // crossed itself or flown away: then it starts anew from rest. Valid until the next call. `image`
  // fits the format. Real-time safe.
  std::span<const Eigen::Vector2d> Track(const cv::Mat& image) noexcept;

  [[nodiscard]] const Curve& rest() const { return rest_; }  // refined [px]
  void Restart() noexcept;

 private:
  void Settle(const cv::Mat& first, std::span<const double> blurs);
  [[nodiscard]] bool IsSound() const noexcept;

  Snake snake_;
  Curve settled_;  // the snake at rest: where it starts anew
  Curve rest_;
  // Of `settled_`; the area is signed, the strength the mean gradient under its points.
  double rest_area_ = 0, rest_length_ = 0, rest_strength_ = 0;
};

}  // namespace palpate
