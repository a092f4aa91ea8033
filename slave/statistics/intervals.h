// Intervals at 95 % of few observations.
#pragma once

namespace palpate {

struct Interval {
  double value = 0, low = 0, high = 0;
};

// How many standard errors of a mean reach to either end, with so many degrees of freedom (> 0).
double StudentReach(double freedom);

// Interval of a share that was `share` in `trials` independent trials (> 0). The share may lie
// between two counts; the interval is that of the count on the safe side. Source: Clopper and
// Pearson (1934).
Interval ShareInterval(double share, int trials);

}  // namespace palpate
