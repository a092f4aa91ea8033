// How far every other row of a picture lies aside: two fields that a camera or its driver joined
// wrongly, or took at different instants. Edges then lie where neither field has them.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"

namespace palpate {

class InterlaceDetector {
 public:
  static constexpr int kMost = 8;       // by which rows are looked for aside [px]
  static constexpr int kHalfSize = 64;  // of the window looked at [px]

  // Throws like GreyFormat; pictures are like `first`.
  explicit InterlaceDetector(const cv::Mat& first);

  // Around `p_I`, inside the picture or not: odd rows against the mean of the two beside them, in
  // whole pixels to the left (> 0) or right; 0: none, or nothing that could tell. Allocation-free.
  [[nodiscard]] int Shift(const cv::Mat& image, const Eigen::Vector2d& p_I) noexcept;

 private:
  // Sum of |differences| with odd rows moved by `shift` [levels].
  [[nodiscard]] long Apart(int shift) const noexcept;

  GreyFormat format_;
  GreyPatch window_;
};

}  // namespace palpate
