// Finds dots in 8-bit pictures: all of them, or those near predicted places.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/dots/blob_labeller.h"
#include "slave/vision/dots/dot.h"
#include "slave/vision/dots/dot_centroid.h"
#include "slave/vision/dots/threshold_map.h"

namespace palpate {

// Where a dot is expected, and what it looked like.
struct ExpectedDot {
  Eigen::Vector2d place{0, 0};   // [px]; not finite: not looked for
  Eigen::Vector2d extent{8, 8};  // half its width and height [px]
  double area = 0;               // [px^2]; 0: any
  double search = 8;             // how far from `place` it may be, along each axis [px]
};

struct SightedDot {
  bool seen = false;
  Dot dot;
};

// Not thread-safe. Allocates only when pictures grow.
class DotFinder {
 public:
  struct Params {
    DotTone tone = DotTone::kDark;
    DotShapeLimits limits;
    std::size_t most = 1024;  // no more dots than this are reported
  };
  // Throws std::invalid_argument naming the parameter.
  explicit DotFinder(const Params& params);

  // Every dot of the picture. False, and no dots: not 8-bit grey, empty, or out of memory. Dots cut
  // by the picture's edge are left out.
  bool Find(const cv::Mat& image, std::vector<Dot>* dots) noexcept;
  // One answer per expected dot: the nearest to its place with an area within a factor of 2.
  bool Track(const cv::Mat& image, const std::vector<ExpectedDot>& expected,
             std::vector<SightedDot>* sighted) noexcept;

  [[nodiscard]] const Params& params() const { return params_; }
  void set_tone(DotTone tone) { params_.tone = tone; }

 private:
  SightedDot Look(const cv::Mat& image, const ExpectedDot& expected);

  Params params_;
  ThresholdMap thresholds_;
  BlobLabeller labeller_;
  std::vector<std::uint64_t> bits_;          // of one row
  std::vector<std::uint8_t> one_threshold_;  // the same for all of a window
};

}  // namespace palpate
