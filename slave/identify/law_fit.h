// A law's constants from tests, by least squares: how well they fit, how sure they are, and what
// cannot be told.
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
  HyperLaw law;
  std::vector<std::string> names;  // of the constants
  Eigen::VectorXd values;          // moduli [Pa], exponents, nu
  // Sandwich estimate: correlated residuals, as of a wrong model, count as such (Newey and West
  // 1987), so that the intervals are valid for the model and not only for the noise.
  Eigen::MatrixXd covariance;
  double rms = 0;  // of the residuals over the peak of all tests [-]
  double bic = 0;  // of Schwarz
  std::string
      unstable;        // range of the instability, as text; empty: none within the data's stretches
  std::string untold;  // combination that the data do not determine; empty: all are determined
  std::string extra;   // further test that would determine it
};

// All tests of one material. Throws std::runtime_error: no constitutive model can be evaluated over
// the data.
LawFit FitLaw(const LawFamily& family, const std::vector<MaterialTest>& tests);

// Those of OfferedLaws() that this number of rows can determine, the best first: stable ones before
// others, then by BIC. `foam`: compressible models instead of incompressible ones.
std::vector<LawFit> FitLaws(const std::vector<MaterialTest>& tests, bool foam);

// Relative to the peak of all tests; `shares`: of every test relative to its own peak.
double RelativeRms(const HyperLaw& law, const std::vector<MaterialTest>& tests,
                   std::vector<double>* shares);

// Half width of the 95 % band of the model's stress in the only row of `one` due to the covariance
// of the constants [Pa].
double PredictionHalfWidth(const LawFamily& family, const LawFit& fit, const MaterialTest& one);

}  // namespace palpate::identify
