// Grey levels across an edge, and the position of the edge in them.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"

namespace palpate {

// Levels along a unit normal, 1 px apart, each the mean over 5 px along the edge, to suppress noise
// and texture. Used by one thread.
class EdgeProfile {
 public:
  // Profiles of at most `max_half` samples to either side.
  EdgeProfile(const GreyFormat& format, int max_half);

  // Reads `half` samples on either side of `p` [px] along `n`. Returns false if the profile leaves
  // the image. `image` must fit the format. Real-time safe.
  bool Read(const cv::Mat& image, const Eigen::Vector2d& p, const Eigen::Vector2d& n,
            int half) noexcept;

  // The next functions evaluate the last profile `k` samples from its centre [levels]. Level: the
  // mean of three samples.
  [[nodiscard]] double Level(int k) const noexcept;
  // The change from three samples behind `k` to three ahead, `first` the nearest on either side.
  [[nodiscard]] double StepAt(int k, int first = 1) const noexcept;
  // Returns the place along the normal [px] of the edge near the sample `at`: the centroid of the
  // slopes of one sign within `half_window` [px], which is moved until it is centred on the edge.
  // Unbiased for every symmetric blur (E. P. Lyvers et al., Subpixel measurements using a
  // moment-based edge operator, PAMI 11, 1989, has the same in two dimensions).
  [[nodiscard]] double Centroid(double sign, int at, double half_window) const noexcept;
  // Samples beyond the edge that Centroid and StepAt need.
  static constexpr int kMargin = 5;

  [[nodiscard]] const GreyFormat& format() const { return format_; }

 private:
  struct Place {
    std::int32_t at = 0;        // of its upper left pixel, in window_
    float right = 0, down = 0;  // from there [px]
  };

  GreyFormat format_;
  std::vector<float> window_, level_;  // [levels]
  std::vector<Place> places_;          // of the samples, line by line
  int half_ = 0;
};

}  // namespace palpate
