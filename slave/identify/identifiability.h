// Which combination of a model's constants the data do not determine, and which further test would.
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
  Eigen::MatrixXd inverse;  // inverse of J^T J, without the undetermined combinations
  Eigen::MatrixXd open;     // covariance of those combinations: they may be anything
  std::string untold;       // least determined combination if its sigma is above a half; else empty
  std::string extra;        // the test over the same stretches that determines it best
};

// `J`: weighted derivatives, `variance` of the weighted residuals.
Identifiability Identify(const LawFamily& family, const Eigen::VectorXd& values,
                         const Eigen::MatrixXd& J, double variance,
                         const std::vector<MaterialTest>& tests);

}  // namespace palpate::identify
