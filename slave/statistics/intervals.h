// Intervals at 95 % of few observations. Header only.
#pragma once

#include <algorithm>
#include <cmath>

namespace palpate {

struct Interval {
  double value = 0, low = 0, high = 0;
};

// How many standard errors of a mean reach to either end, with so many degrees of freedom (>= 2).
// Source: Cornish and Fisher's expansion of Student's t (Abramowitz and Stegun, 26.7.5); 3.1 % too
// small for 2 degrees, 0.7 % for 3.
inline double StudentReach(double freedom) {
  constexpr double kZ = 1.959964;
  const double z2 = kZ * kZ, v = freedom;
  return kZ * (1 + (z2 + 1) / (4 * v) + (5 * z2 * z2 + 16 * z2 + 3) / (96 * v * v) +
               (3 * z2 * z2 * z2 + 19 * z2 * z2 + 17 * z2 - 15) / (384 * v * v * v));
}

// Probability of at most `hits` out of `trials` with probability `p` each.
inline double BinomialAtMost(int hits, int trials, double p) {
  if (p <= 0 || hits >= trials) return 1;
  if (p >= 1) return 0;
  double sum = 0, chosen = 0;  // logarithm of the number of ways
  for (int k = 0; k <= hits; ++k) {
    sum += std::exp(chosen + k * std::log(p) + (trials - k) * std::log1p(-p));
    chosen += std::log(static_cast<double>(trials - k) / (k + 1));
  }
  return std::min(1.0, sum);
}

// Interval of a share that was `share` in `trials` independent trials (> 0). The share may lie
// between two counts; the interval is that of the count on the safe side. Source: Clopper and
// Pearson (1934).
inline Interval ShareInterval(double share, int trials) {
  constexpr double kTail = 0.025;
  const int fewest = static_cast<int>(std::floor(share * trials + 1e-9));
  const int most = static_cast<int>(std::ceil(share * trials - 1e-9));
  // The p in [0, 1] where a falling probability passes `level`.
  const auto solve = [](const auto& falling, double level) {
    double low = 0, high = 1;
    for (int i = 0; i < 50; ++i) {
      const double middle = (low + high) / 2;
      (falling(middle) > level ? low : high) = middle;
    }
    return (low + high) / 2;
  };
  return {
      share,
      fewest == 0
          ? 0
          : solve([&](double p) { return BinomialAtMost(fewest - 1, trials, p); }, 1 - kTail),
      most == trials ? 1 : solve([&](double p) { return BinomialAtMost(most, trials, p); }, kTail)};
}

}  // namespace palpate
