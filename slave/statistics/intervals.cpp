#include "slave/statistics/intervals.h"

#include <cmath>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace palpate {
namespace {

constexpr double kTail = 0.025;  // probability beyond either end

}  // namespace

double StudentReach(double freedom) {
  return -quantile(boost::math::students_t(freedom), kTail);
}

Interval ShareInterval(double share, int trials) {
  using boost::math::binomial;
  const double fewest = std::floor(share * trials + 1e-9);
  const double most = std::ceil(share * trials - 1e-9);
  return {share, binomial::find_lower_bound_on_p(trials, fewest, kTail),
          binomial::find_upper_bound_on_p(trials, most, kTail)};
}

}  // namespace palpate
