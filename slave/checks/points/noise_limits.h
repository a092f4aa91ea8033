// Statistics of points that both the fits of loads and their checks use.
#pragma once

namespace palpate {

struct NoiseLimits {
  // A deviation beyond this limit is not noise [sigma]. [derived: noise is beyond it once in two
  // million]
  static constexpr double kSignificant = 5;
  // Scatter of the points, by their stated sigmas, at least [-]. [tuned: surface_flags_test,
  // dents of another tension]
  static constexpr double kMinScatter = 0.25;
};

}  // namespace palpate
