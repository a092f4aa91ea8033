// Normalised cross-correlation of a template with every place of a window.
//
//   C(x, y) = sum T~ I~ / sqrt(sum T~^2 sum I~^2),   T~ = T - mean of T,
//   I~ = I - mean of I under the template (at each place anew)
//
// Source: paper A, eq. (1), with the two means the right way round (the sentence below the printed
// equation swaps them). Invariant to a gain > 0 and an offset of the light. All sums are exact
// integers; only the last division rounds.
#pragma once

#include <cstdint>
#include <vector>

#include "slave/vision/grey.h"

namespace palpate {

// Scores of all places (upper left corners) of the template in a window.
struct ScoreMap {
  int width = 0, height = 0;
  std::vector<double> scores;  // width x height, [-1, 1] or kNoMatch

  [[nodiscard]] double At(int x, int y) const {
    return scores[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

class Ncc {
 public:
  // The score of a window without contrast: undefined in eq. (1), below every other here.
  static constexpr double kNoMatch = -2;

  // Throws std::invalid_argument: an empty template, or one without contrast.
  explicit Ncc(GreyPatch pattern);

  // Matches at every place of `window`; an empty map where the template is larger. Allocates only
  // when a window is larger than all before. Not thread-safe.
  const ScoreMap& Match(const GreyPatch& window);

  [[nodiscard]] const GreyPatch& pattern() const { return pattern_; }

 private:
  void SumRows(const GreyPatch& window, int x);
  void MatchColumn(const GreyPatch& window, int x);

  GreyPatch pattern_;
  std::int64_t count_ = 0;     // pixels n
  std::int64_t sum_ = 0;       // sum T
  std::int64_t variance_ = 0;  // n sum T^2 - (sum T)^2
  ScoreMap map_;
  GreyPatch strip_;                                 // the window's columns under the template
  std::vector<std::int64_t> row_sum_, row_square_;  // of the strip
};

}  // namespace palpate
