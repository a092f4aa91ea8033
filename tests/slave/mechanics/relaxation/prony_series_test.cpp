// Closed forms of a series of exponentials under histories that are straight within the steps.
#include "slave/mechanics/relaxation/prony_series.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/thrown.h"

namespace palpate {
namespace {

const std::vector<RelaxationTerm> kTissue{{0.3, 0.5}, {0.2, 5}};

Wrench UnitWrench(double value) {
  Wrench force = Wrench::Zero();
  force[2] = value;
  return force;
}

// Integral of g(t) = 1 - sum share (1 - exp(-t / time)) from 0 to t.
double Integral(double t) {
  double integral = t;
  for (const auto& [share, time] : kTissue) {
    integral -= share * (t + time * std::expm1(-t / time));
  }
  return integral;
}

// F = rate * integral of g over the ramp; a hold and a return follow by superposition. Long steps
// are as exact as short ones.
TEST(PronySeries, RampsHoldsAndReturnsAreExactForStepsOfAnyLength) {
  const double rate = 3, top = 2;
  const auto at = [](double t) { return t > 0 ? Integral(t) : 0; };
  for (const double step : {0.01, 0.25, 1.0}) {
    const PronySeries series(kTissue, step);
    RelaxationMemory memory;
    for (int k = 1; k * step < 9; ++k) {
      const double t = k * step;
      const double elastic = rate * (std::min(t, top) - std::clamp(t - top, 0.0, top));
      const double expected = rate * (at(t) - 2 * at(t - top) + at(t - 2 * top));
      EXPECT_NEAR(series.Advance(UnitWrench(elastic), &memory)[2], expected, 1e-12)
          << step << " " << t;
    }
  }
}

// Under a constant force the elastic force grows like the creep function J, whose convolution with
// g is one. The test convolves the values that ElasticFor returned, in another history.
TEST(PronySeries, TheElasticForceOfALoadRelaxesToTheLoad) {
  const PronySeries series(kTissue, 0.1);
  RelaxationMemory memory, other;
  double last = 0, left = 1;
  for (const auto& term : kTissue) left -= term.share;
  for (int k = 0; k < 2000; ++k) {
    const Wrench elastic = series.ElasticFor(UnitWrench(1), memory);
    series.Advance(elastic, &memory);
    EXPECT_GT(elastic[2], last);
    last = elastic[2];
    EXPECT_NEAR(series.Advance(elastic, &other)[2], 1, 1e-12);
  }
  EXPECT_NEAR(last, 1 / left, 1e-9);
}

TEST(PronySeries, RefusesWhatIsNoRelaxation) {
  const auto refused = [](std::vector<RelaxationTerm> terms, double step) {
    return !Thrown<std::invalid_argument>([&] { PronySeries(terms, step); }).empty();
  };
  EXPECT_TRUE(refused({{0.5, 1}, {0.5, 2}}, 0.1));
  EXPECT_TRUE(refused({{-0.1, 1}}, 0.1));
  EXPECT_TRUE(refused({{0.1, 0}}, 0.1));
  EXPECT_TRUE(refused({{0.1, 1}}, 0));
  EXPECT_TRUE(refused({{0.1, std::numeric_limits<double>::quiet_NaN()}}, 0.1));
  EXPECT_TRUE(refused(std::vector<RelaxationTerm>(9, {0.01, 1}), 0.1));
}

}  // namespace
}  // namespace palpate
