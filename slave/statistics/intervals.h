// Intervals at 95 % of few observations. Header only.
#pragma once

#include <cmath>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace palpate {

struct Interval {
  double value = 0, low = 0, high = 0;
};

inline constexpr double kTail = 0.025;  // beyond either end

// How many standard errors of a mean reach to either end, with so many degrees of freedom (> 0).
inline double StudentReach(double freedom) {
  return -quantile(boost::math::students_t(freedom), kTail);
}

// Interval of a share that was `share` in `trials` independent trials (> 0). The share may lie
// between two counts; the interval is that of the count on the safe side. Source: Clopper and
// Pearson (1934).
inline Interval ShareInterval(double share, int trials) {
  using boost::math::binomial;
  const double fewest = std::floor(share * trials + 1e-9);
  const double most = std::ceil(share * trials - 1e-9);
  return {share, binomial::find_lower_bound_on_p(trials, fewest, kTail),
          binomial::find_upper_bound_on_p(trials, most, kTail)};
}

}  // namespace palpate
