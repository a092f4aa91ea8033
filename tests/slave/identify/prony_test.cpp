#include "slave/identify/prony.h"

#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "tests/support/thrown.h"

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

TEST(Prony, FindsLongTermModulusAndTimeConstants) {
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

// Stress of one exponential under a ramp to a strain of 0.5.
RelaxationTable Ramp(double G_inf, double G, double tau, double rate) {
  RelaxationTable table{.name = "ramp", .shear = true};
  for (int i = 0; i <= 100; ++i) {
    const double strain = 0.005 * i, t = strain / rate;
    table.time.push_back(t);
    table.strain.push_back(strain);
    table.stress.push_back(G_inf * strain + G * tau * rate * (1 - std::exp(-t / tau)));
  }
  return table;
}

// Noise of 2 % of the peak: no modulus that is reported may be zero.
TEST(Prony, DropsTermsThatMayBeZero) {
  RelaxationTable noisy = Hold(2e3, 3e3, 10, 200, 0.5);
  std::mt19937 engine(3);
  std::normal_distribution<double> normal(0, 10);
  for (double& stress : noisy.stress) stress += normal(engine);
  const PronyFit fit = FitProny({noisy});
  ASSERT_FALSE(fit.terms.empty());
  for (const PronyTerm& term : fit.terms) EXPECT_GT(term.modulus, 1.96 * term.sigma) << term.time;
  EXPECT_NEAR(fit.At(0), fit.instant, 1e-9 * fit.instant);
  EXPECT_NEAR(fit.At(1e9), fit.equilibrium, 1e-9 * fit.instant);
}

std::string PronyComplaint(const std::vector<RelaxationTable>& tables) {
  return Thrown<InputError>([&] { FitProny(tables); });
}

// A ramp of a law that stiffens, such as a compression test; with a hold, a return or another rate
// it could be distinguished from fading.
TEST(Prony, RefusesOneRampAtOneRate) {
  const RelaxationTable ramp = Ramp(2e3, 3e3, 10, 0.01);
  EXPECT_NE(PronyComplaint({ramp}).find("only rises, at one rate"), std::string::npos);
  EXPECT_NE(PronyComplaint({ramp, ramp}).find("only rises, at one rate"), std::string::npos);
  EXPECT_EQ(PronyComplaint({ramp, Ramp(2e3, 3e3, 10, 0.05)}), "");
  RelaxationTable held = ramp;
  held.time.push_back(held.time.back() + 5);
  held.strain.push_back(held.strain.back());
  held.stress.push_back(0.9 * held.stress.back());
  EXPECT_EQ(PronyComplaint({held}), "");
  RelaxationTable back = ramp;
  back.time.push_back(back.time.back() + 10);
  back.strain.push_back(0.4);
  back.stress.push_back(0.5 * back.stress.back());
  EXPECT_EQ(PronyComplaint({back}), "");
}

TEST(Prony, RefusesShearTogetherWithOtherStrainsAndNoStrain) {
  EXPECT_NE(PronyComplaint({Ramp(2e3, 0, 1, 0.01), Hold(2e3, 0, 1, 50, 0.1)}).find("one of them"),
            std::string::npos);
  EXPECT_THROW(FitProny({{"rest", false, {0, 1, 2, 3}, {0, 0, 0, 0}, {0, 0, 0, 0}}}), InputError);
}

}  // namespace
}  // namespace palpate::identify
