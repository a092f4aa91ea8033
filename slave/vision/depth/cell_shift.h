// The robust mean of how far depths changed within a cell.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slave/vision/depth/rest_depth.h"

namespace palpate {

class CellShift {
 public:
  struct Mean {
    double shift = 0;   // [counts], positive: away from the camera
    double spread = 0;  // standard deviation of those in the mean [counts]
    int count = 0;      // pixels that have a depth, now and at rest
  };
  // `edge` of the largest cell [px]; `sigma` of one depth [counts].
  CellShift(int edge, double sigma);

  // The mean of the changes that lie within three sigma of their median, or three times their own
  // spread where that is wider. nullopt: fewer than `least` pixels. Allocation-free.
  [[nodiscard]] std::optional<Mean> Of(const cv::Mat& depth, const RestDepth& rest,
                                       const DepthCell& cell, int least) noexcept;

 private:
  double sigma_;                                // in fractions of a count
  std::vector<std::int32_t> changes_, sample_;  // in fractions of a count
};

}  // namespace palpate
