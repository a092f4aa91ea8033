// Finds a template in a window by normalised cross-correlation.
#pragma once

#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"

namespace palpate {

// Scores of all positions (upper left corners) of a template in a window, [-1, 1].
using ScoreMap = cv::Mat_<float>;

// Normalised cross-correlation of a template with every position of a window.
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
  // At one position, which is inside: faster than a map for a few positions of a small template.
  [[nodiscard]] double At(const GreyPatch& window, int x, int y) const;

  [[nodiscard]] const GreyPatch& pattern() const { return pattern_; }
  [[nodiscard]] const ScoreMap& map() const { return map_; }  // of the last window

 private:
  GreyPatch pattern_;
  double mean_ = 0, contrast_ = 0;  // of the template's levels; sum T~^2
  cv::Mat levels_;                  // levels of the template for cv::matchTemplate
  ScoreMap map_;
};

}  // namespace palpate
