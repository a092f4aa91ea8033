#include "slave/tactile/localise/normal_correction.h"

#include <cmath>
#include <cstddef>

namespace palpate {

SignalShape ShapeOf(const TactileSignals& change, double quiet) noexcept {
  SignalShape u;
  for (int i = 0; i < kElectrodeCount; ++i) {
    u[i] = static_cast<double>(change[static_cast<std::size_t>(i)]);
  }
  return u / (quiet + u.norm());
}

Eigen::Vector3d Correction(const LocaliserWeights& weights, const SignalShape& u) noexcept {
  Eigen::Vector3d correction(0, 0, 0);
  for (Eigen::Index j = 0; j < weights.centres.cols(); ++j) {
    const double apart = (weights.centres.col(j) - u).squaredNorm();
    correction += std::exp(-weights.gamma * apart) * weights.corrections.col(j);
  }
  return correction;
}

}  // namespace palpate
