// A law's constants from tests, by least squares, with the quality of the fit and intervals.
//
// For given exponents the stresses are linear in the moduli, which are found exactly and are not
// negative (except Yeoh's higher ones); the exponents are found by the Levenberg-Marquardt method
// (Eigen's version of MINPACK, because the problems are small and dense) from the best of a fixed
// grid, so that the same data give the same answer.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/identify/hyper_law.h"
#include "slave/identify/material_test.h"

namespace palpate::identify {

// Measured stress over a law's, minus one, where the tests begin: over the rows up to 10 % strain,
// or up to 40 % if fewer do not determine it well.
struct AtRest {
  double off = 0, sigma = 0;  // of several tests, that which is farthest off [-]

  // Returns the part of `off` that the scatter of the rows does not explain.
  [[nodiscard]] double excess() const { return std::max(0.0, std::abs(off) - 2 * sigma); }
};
// A law beyond the first limit is reported as off at rest; beyond the second it is not proposed
// [-].
inline constexpr double kOffAtRest = 0.1, kMaxOffAtRest = 0.5;

struct LawFit {
  LawFamily family;
  HyperLaw law;
  std::vector<std::string> names;  // of the constants
  Eigen::VectorXd values;          // moduli [Pa], exponents
  // Sandwich estimate (Newey and West 1987): it includes correlated residuals, as of a wrong model,
  // so that the intervals cover model errors and not only noise.
  Eigen::MatrixXd covariance;
  // Sigma of the modulus at rest [Pa]: from the covariance, and from how far the law is off at
  // rest.
  double young_sigma = 0;
  AtRest at_rest;  // set by FitLawsFromRest
  double rms = 0;  // of the residuals over the peak of all tests [-]
  double bic = 0;  // of Schwarz
  // Range of the instability, as text; empty: none within the data's stretches.
  std::string unstable;
};

// All tests of one material. Throws std::runtime_error: no constitutive model can be evaluated over
// the data.
LawFit FitLaw(const LawFamily& family, const std::vector<MaterialTest>& tests);

// Fits the laws of OfferedLaws() that this number of rows can determine. Returns the best first:
// stable laws before others, then by BIC; among laws whose BIC does not differ significantly from
// the best the simplest is first. A modulus whose 95 % interval includes zero is dropped and the
// model fitted without it. If this makes it equal to a simpler model of the list, it is not
// repeated. `dropped`: model and modulus of each, unless null.
std::vector<LawFit> FitLaws(const std::vector<MaterialTest>& tests,
                            std::vector<std::string>* dropped = nullptr);

// Relative to the peak of all tests; `shares`: of every test relative to its own peak.
double RelativeRms(const HyperLaw& law, const std::vector<MaterialTest>& tests,
                   std::vector<double>* shares);

AtRest FindAtRest(const HyperLaw& law, const std::vector<MaterialTest>& tests);

// FitLaws up to the largest strain with which the best law also holds at rest: a law that follows a
// test to failure may miss its modulus at rest by a factor of two. Tries all strains, then half of
// them, and so on; if none is sufficient, it uses the range with the smallest error.
// `may_leave_out` false: uses all strains.
struct FitFromRest {
  std::vector<MaterialTest> tests;  // rows that were fitted
  std::vector<LawFit> fits;
  std::vector<std::string> dropped;  // see FitLaws
  double largest_strain = 0;         // of these rows [-]
  bool is_all = true;                // none was left out
};
FitFromRest FitLawsFromRest(const std::vector<MaterialTest>& tests, bool may_leave_out = true);

}  // namespace palpate::identify
