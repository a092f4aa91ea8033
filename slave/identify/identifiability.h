// Which combination of a law's constants the data do not tell, and which further test would.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/identify/hyper_law.h"
#include "slave/identify/material_test.h"

namespace palpate::identify {

// Derivatives of all predicted stresses by the constants, by differences [Pa per unit].
Eigen::MatrixXd Sensitivities(const LawFamily& family, const Eigen::VectorXd& values,
                              const std::vector<MaterialTest>& tests);

struct Identifiability {
  Eigen::MatrixXd inverse;  // of J^T J, without the combinations that are not told at all
  Eigen::MatrixXd open;     // covariance of those combinations: they may be anything
  Eigen::VectorXd weak;     // the combination told worst, in relative changes
  std::string untold;       // it in words where one sigma is above a half; else empty
  std::string extra;        // the test over the same stretches that tells most of it
};

// `J`: weighted derivatives, `variance` of the weighted residuals.
Identifiability Identify(const LawFamily& family, const Eigen::VectorXd& values,
                         const Eigen::MatrixXd& J, double variance,
                         const std::vector<MaterialTest>& tests);

}  // namespace palpate::identify
