// A law's constants from tests, by least squares, with the quality of the fit and intervals.
//
// For given exponents the stresses are linear in the moduli, which are found exactly, none negative
// (but Yeoh's higher ones); the exponents are sought by Levenberg and Marquardt's method (MINPACK
// as Eigen has it: the problems are small and dense, and it brings no package) from the best of a
// fixed grid, so that the same data give the same answer.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/identify/hyper_law.h"
#include "slave/identify/material_test.h"

namespace palpate::identify {

struct LawFit {
  LawFamily family;
  HyperLaw law;
  std::vector<std::string> names;  // of the constants
  Eigen::VectorXd values;          // moduli [Pa], exponents
  // Sandwich estimate: correlated residuals, as of a wrong model, count as such (Newey and West
  // 1987), so that the intervals are valid for the model and not only for the noise.
  Eigen::MatrixXd covariance;
  double young_sigma = 0;  // of the modulus at rest, from the covariance [Pa]
  double rms = 0;          // of the residuals over the peak of all tests [-]
  double bic = 0;          // of Schwarz
  // Range of the instability, as text; empty: none within the data's stretches.
  std::string unstable;
};

// All tests of one material. Throws std::runtime_error: no constitutive model can be evaluated over
// the data.
LawFit FitLaw(const LawFamily& family, const std::vector<MaterialTest>& tests);

// Those of OfferedLaws() that this number of rows can determine, the best first: stable ones before
// others, then by BIC; the simplest of those that BIC does not separate from the least comes first.
// A modulus whose 95 % interval includes zero is dropped and the model fitted without it. What is
// then a simpler model of the list is not repeated. `dropped`: model and modulus of each, unless
// null.
std::vector<LawFit> FitLaws(const std::vector<MaterialTest>& tests,
                            std::vector<std::string>* dropped = nullptr);

// Relative to the peak of all tests; `shares`: of every test relative to its own peak.
double RelativeRms(const HyperLaw& law, const std::vector<MaterialTest>& tests,
                   std::vector<double>* shares);

// Residuals over the rows of small strain, relative to the largest stress among them; 0: none.
inline constexpr double kSmallStrain = 0.1;  // [-]
double SmallStrainRms(const HyperLaw& law, const std::vector<MaterialTest>& tests);

}  // namespace palpate::identify
