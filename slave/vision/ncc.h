// Finds a template in a window by normalised cross-correlation.
#pragma once

#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"

namespace palpate {

// Scores of all positions (upper left corners) of a template in a window, [-1, 1].
using ScoreMap = cv::Mat_<float>;

// Normalised cross-correlation of a template with every place of a window.
//
//   C(x, y) = sum T~ I~ / sqrt(sum T~^2 sum I~^2),   T~ = T - mean of T,
//   I~ = I - mean of I under the template (at each place again)
//
// Source: paper A, eq. (1), with the two means the right way round (the sentence below the printed
// equation swaps them). Invariant to a gain > 0 and an offset of the light.
class Ncc {
 public:
  // Throws std::invalid_argument: an empty template, or one without contrast.
  explicit Ncc(GreyPatch pattern);

  // Scores every position of `window`; an empty map if the template is larger. 0 where the window
  // has no contrast. Not thread-safe.
  const ScoreMap& Match(const GreyPatch& window);

  [[nodiscard]] const GreyPatch& pattern() const { return pattern_; }

 private:
  GreyPatch pattern_;
  cv::Mat levels_;  // of the template, as cv::matchTemplate takes them
  ScoreMap map_;    // of the last window
};

}  // namespace palpate
