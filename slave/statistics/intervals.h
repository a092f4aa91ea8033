// Intervals at 95 % of few observations.
#pragma once

namespace palpate {

struct Interval {
  double value = 0, low = 0, high = 0;
};

// Returns the half width of an interval of a mean in standard errors, for `freedom` degrees of
// freedom (> 0).
double StudentReach(double freedom);

// Returns the interval of a probability that was observed as `share` in `trials` independent trials
// (> 0). If the share is between two counts, the interval is that of the count on the safe side.
// Source: Clopper and Pearson (1934).
Interval ShareInterval(double share, int trials);

}  // namespace palpate
