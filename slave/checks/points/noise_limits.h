// Statistics of points that both the fits of loads and their checks use.
#pragma once

namespace palpate {

struct NoiseLimits {
  // From which on something is no noise [sigma]. [derived: noise is beyond it once in two million]
  static constexpr double kSignificant = 5;
  // Scatter of the points, by their stated sigmas, at least [-]. [tuned: surface_doubts_test,
  // dents of another tension]
  static constexpr double kLeastScatter = 0.25;
};

}  // namespace palpate
