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
  // Sandwich: residuals that go on along a curve, as those of a wrong law do, count as what they
  // are (Newey and West 1987), so that bands hold for the law and not for the noise alone.
  Eigen::MatrixXd covariance;
  double rms = 0;        // of the residuals over the peak of all tests [-]
  double bic = 0;        // of Schwarz
  std::string unstable;  // where, in words; empty: nowhere within the data's stretches
  std::string untold;    // which combination the data do not tell; empty: all are told
  std::string extra;     // which press would tell
  Eigen::VectorXd weak;  // that combination, in relative changes of the constants
};

// All tests of one material. Throws std::runtime_error: no law can be evaluated over the data.
LawFit FitLaw(const LawFamily& family, const std::vector<MaterialTest>& tests);

// Those of OfferedLaws() that can be told from so many rows, the best first: stable ones before
// others, then by BIC. `foam`: compressible laws instead of incompressible ones.
std::vector<LawFit> FitLaws(const std::vector<MaterialTest>& tests, bool foam);

// Over the peak of all tests; `shares`: of every test over its own peak.
double RelativeRms(const HyperLaw& law, const std::vector<MaterialTest>& tests,
                   std::vector<double>* shares);

// Half width of the band of 95 % that the constants' covariance gives the law's answer [Pa].
double PredictionHalfWidth(const LawFamily& family, const LawFit& fit, const MaterialTest& test,
                           std::size_t row);

}  // namespace palpate::identify
