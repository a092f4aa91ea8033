// Detects interlaced images: the offset of every other row, when a camera or its driver joined two
// fields wrongly, or took them at different times. Edges then have a position of neither field.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"

namespace palpate {

class InterlaceDetector {
 public:
  static constexpr int kMost = 8;       // largest offset of rows that is searched [px]
  static constexpr int kHalfSize = 64;  // of the searched window [px]

  // Throws like GreyFormat; images are like `first`.
  explicit InterlaceDetector(const cv::Mat& first);

  // Around `p_I`, inside the image or not: odd rows against the mean of their two neighbours, in
  // whole pixels to the left (> 0) or right; 0: none, or undetermined. Allocation-free.
  [[nodiscard]] int Shift(const cv::Mat& image, const Eigen::Vector2d& p_I) noexcept;

 private:
  // Sum of |differences| with odd rows moved by `shift` [levels].
  [[nodiscard]] long Apart(int shift) const noexcept;

  GreyFormat format_;
  GreyPatch window_;
};

}  // namespace palpate
