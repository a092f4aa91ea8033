// The two halves of a fitted localiser that fitting and locating share.
#pragma once

#include <Eigen/Core>

#include "slave/tactile/localise/fitted_localiser.h"

namespace palpate {

// u: which electrodes moved how, whatever the strength.
using SignalShape = Eigen::Matrix<double, kElectrodeCount, 1>;

SignalShape ShapeOf(const TactileSignals& change, double quiet) noexcept;

// sum_j a_j exp(-gamma |u - u_j|^2). Allocation-free.
Eigen::Vector3d Correction(const LocaliserWeights& weights, const SignalShape& u) noexcept;

}  // namespace palpate
