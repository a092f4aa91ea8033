#include "slave/identify/prony.h"

#include <cmath>

#include <gtest/gtest.h>

#include "shared/text/text.h"

namespace palpate::identify {
namespace {

// A ramp of 1 s to 10 % and a hold; closed form of one exponential under a ramp.
RelaxationTable Hold(double G_inf, double G, double tau, double end, double step) {
  RelaxationTable table{.name = "hold"};
  for (double t = 0; t <= end; t += step) {
    const double rate = 0.1, ramp = std::min(t, 1.0);
    const double branch = tau * rate * (std::exp(-(t - ramp) / tau) - std::exp(-t / tau));
    table.time.push_back(t);
    table.strain.push_back(rate * ramp);
    table.stress.push_back(G_inf * rate * ramp + G * branch);
  }
  return table;
}

TEST(Prony, FindsWhatStaysAndHowFastTheRestGoes) {
  const PronyFit fit = FitProny({Hold(2e3, 3e3, 10, 200, 0.1)});
  EXPECT_LT(fit.rms, 2e-3);
  EXPECT_NEAR(fit.equilibrium, 2e3, 40);
  EXPECT_NEAR(fit.instant, 5e3, 250);
  double weighted = 0, sum = 0;
  for (const PronyTerm& term : fit.terms) weighted += term.modulus * term.time, sum += term.modulus;
  EXPECT_NEAR(weighted / sum, 10, 2);
}

TEST(Prony, OfAnElasticBodyIsItsModulus) {
  const PronyFit fit = FitProny({Hold(2e3, 0, 1, 50, 0.1)});
  EXPECT_NEAR(fit.equilibrium, 2e3, 1);
  EXPECT_NEAR(fit.instant, 2e3, 5);
}

TEST(Prony, RefusesWhatWasNotStrained) {
  EXPECT_THROW(FitProny({{"rest", {0, 1, 2, 3}, {0, 0, 0, 0}, {0, 0, 0, 0}}}), InputError);
}

}  // namespace
}  // namespace palpate::identify
