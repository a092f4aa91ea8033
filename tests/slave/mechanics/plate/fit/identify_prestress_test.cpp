#include "slave/mechanics/plate/fit/identify_prestress.h"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

constexpr double kRadius = 0.039, kModulus = 2e6, kNu = 0.45, kThickness = 0.0005, kWidth = 0.004;

PlateLargeModel::Params Plate(double prestress = 0, int order = 16) {
  return {kRadius, kThickness, kModulus, kNu, prestress, order};
}

std::vector<Vector2d> Dots() {
  std::vector<Vector2d> dots;
  for (int i = -2; i <= 2; ++i) {
    for (int j = -3; j <= 3; ++j) dots.emplace_back(0.012 * i, 0.010 * j);
  }
  std::erase_if(dots, [](const Vector2d& p) { return p.norm() > 0.92 * kRadius; });
  return dots;
}

// A state of the membrane, by more modes than the search has.
MembraneState See(double prestress, double pressure, const Vector2d& p, double force, double sigma,
                  std::mt19937* random) {
  PlateLargeModel plate(Plate(prestress, 20));
  std::vector<Contact> contacts;
  if (pressure != 0) {
    contacts.push_back({.kind = Contact::Kind::kForce,
                        .width = 2 * kRadius,
                        .prescribed_O = {0, 0, pressure * std::numbers::pi * kRadius * kRadius}});
  }
  contacts.push_back({.kind = Contact::Kind::kForce,
                      .p_O = {p.x(), p.y(), 0},
                      .width = kWidth,
                      .prescribed_O = {0, 0, force}});
  std::vector<ContactResponse> responses(contacts.size());
  plate.Respond(contacts, responses);
  MembraneState state;
  state.p_O = p;
  state.force = force;
  state.width = kWidth;
  state.points_O = Dots();
  std::normal_distribution<double> noise(0, sigma);
  for (const Vector2d& dot : state.points_O) {
    state.heights.push_back(plate.Displacement(dot) + noise(*random));
    state.sigmas.push_back(sigma);
  }
  return state;
}

// Reference: the tension that the picture was made with. Four standard deviations, and half a
// percent for the orders of the modes.
TEST(IdentifyMembrane, FindsTheTensionFromOneKnownLoad) {
  std::mt19937 random(1);
  for (const double tension : {3.0, 12.0, 60.0}) {
    const MembraneState state = See(tension, 0, {0.006, 0.004}, -0.02, 2e-5, &random);
    const MembraneIdentity it = IdentifyMembrane(Plate(), std::span(&state, 1));
    ASSERT_TRUE(it.identified) << tension << it.reason << it.prestress << " " << it.prestress_sigma;
    EXPECT_NEAR(it.prestress, tension, 4 * it.prestress_sigma + 5e-3 * tension);
    EXPECT_LT(it.prestress_sigma, 0.1 * tension);
    EXPECT_NEAR(it.residual, 1, 0.5);
    EXPECT_EQ(it.young_modulus, kModulus);
    EXPECT_EQ(it.pressure, 0);
  }
}

// Reference: chi-square over 12 pictures: the mean of squares has a standard deviation of
// sqrt(2 / 12) = 0.41; three of them are allowed.
TEST(IdentifyMembrane, SigmaIsTheTensionsStandardDeviation) {
  std::mt19937 random(2);
  double sum = 0;
  for (int i = 0; i < 12; ++i) {
    const MembraneState state = See(12, 0, {0.006, 0.004}, -0.01, 3e-5, &random);
    const MembraneIdentity it = IdentifyMembrane(Plate(), std::span(&state, 1));
    sum += std::pow((it.prestress - 12) / it.prestress_sigma, 2);
  }
  EXPECT_GT(sum / 12, 0.1);
  EXPECT_LT(sum / 12, 2.3);
}

// A force known to 5 % leaves a tension known to not much better.
TEST(IdentifyMembrane, TheLoadsOwnErrorCounts) {
  std::mt19937 random(3);
  MembraneState state = See(30, 0, {0, 0}, -0.02, 1e-5, &random);
  const double exact = IdentifyMembrane(Plate(), std::span(&state, 1)).prestress_sigma;
  state.force_sigma = 0.05 * 0.02;
  const double vague = IdentifyMembrane(Plate(), std::span(&state, 1)).prestress_sigma;
  EXPECT_GT(vague, 0.03 * 30);
  EXPECT_LT(vague, 0.12 * 30);
  EXPECT_LT(exact, 0.5 * vague);
}

TEST(IdentifyMembrane, TwoLoadsTellTheModulusToo) {
  std::mt19937 random(4);
  const std::vector<MembraneState> states = {See(10, 0, {0, 0.005}, -0.005, 2e-5, &random),
                                             See(10, 0, {0, 0.005}, -0.05, 2e-5, &random)};
  PlateLargeModel::Params guess = Plate();
  guess.young_modulus = 3e6;
  const MembraneIdentity it = IdentifyMembrane(guess, states, {.modulus = true});
  ASSERT_TRUE(it.identified) << it.reason;
  EXPECT_NEAR(it.young_modulus, kModulus, 4 * it.young_modulus_sigma + 0.02 * kModulus);
  EXPECT_NEAR(it.prestress, 10, 4 * it.prestress_sigma + 0.5);
}

// Reference: the pressure and tension that the bulge was made with; and the bulge equation of thin
// membranes, p = 4 N h / a^2, which is right to a tenth here.
TEST(IdentifyMembrane, TellsPressureFromTensionByTheRestShapeAndOneLoad) {
  std::mt19937 random(5);
  const double tension = 20, pressure = 80;
  const std::vector<MembraneState> states = {
      See(tension, pressure, {0, 0}, 0, 1e-5, &random),
      See(tension, pressure, {0.008, 0}, -0.03, 1e-5, &random)};
  const MembraneIdentity it = IdentifyMembrane(Plate(), states, {.pressure = true});
  ASSERT_TRUE(it.identified) << it.reason;
  EXPECT_NEAR(it.pressure, pressure, 4 * it.pressure_sigma + 0.01 * pressure);
  EXPECT_NEAR(it.prestress, tension, 4 * it.prestress_sigma + 0.02 * tension);
  const double h = *std::ranges::max_element(states[0].heights);
  const double N = it.prestress + 0.8 * kModulus * kThickness * h * h / (kRadius * kRadius);
  EXPECT_NEAR(4 * N * h / (kRadius * kRadius) / it.pressure, 1, 0.1);
}

TEST(IdentifyMembrane, SaysWhyTheTensionIsNotKnown) {
  std::mt19937 random(6);
  // A tension of 0.2 N/m where the stretched membrane carries a hundred times as much.
  MembraneState state = See(0.2, 0, {0, 0}, -0.3, 1.5e-4, &random);
  MembraneIdentity it = IdentifyMembrane(Plate(), std::span(&state, 1));
  EXPECT_FALSE(it.identified);
  EXPECT_THAT(it.reason, HasSubstr("press less")) << it.prestress << " " << it.prestress_sigma;
  state = See(1, 0, {0, 0}, -2e-4, 5e-5, &random);
  it = IdentifyMembrane(Plate(), std::span(&state, 1));
  EXPECT_FALSE(it.identified);
  EXPECT_THAT(it.reason, HasSubstr("press harder"));
  state = See(10, 0, {0.02, 0}, -0.05, 1e-6, &random);
  state.p_O = {-0.02, 0};
  it = IdentifyMembrane(Plate(), std::span(&state, 1));
  EXPECT_FALSE(it.identified);
  EXPECT_THAT(it.reason, HasSubstr("no tension explains"));
  state.force = 0;
  EXPECT_FALSE(IdentifyMembrane(Plate(), std::span(&state, 1)).identified);
  EXPECT_FALSE(IdentifyMembrane(Plate(), {}).identified);
}

TEST(IdentifyMembrane, RefusesStatesThatAreNone) {
  std::mt19937 random(7);
  const MembraneState good = See(10, 0, {0, 0}, -0.02, 1e-5, &random);
  const auto refused = [](const MembraneState& state) {
    EXPECT_THROW(IdentifyMembrane(Plate(), std::span(&state, 1)), std::invalid_argument);
  };
  MembraneState bad = good;
  bad.heights.pop_back();
  refused(bad);
  bad = good;
  bad.sigmas[3] = 0;
  refused(bad);
  bad = good;
  bad.heights[3] = std::nan("");
  refused(bad);
  bad = good;
  bad.points_O[0].x() = 0.05;
  refused(bad);
  bad = good;
  bad.force = std::nan("");
  refused(bad);
}

}  // namespace
}  // namespace palpate
