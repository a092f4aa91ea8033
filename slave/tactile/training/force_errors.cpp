#include "slave/tactile/training/force_errors.h"

#include <cmath>
#include <limits>

namespace palpate {
namespace {

struct AxisErrors {
  double rmse, smse, correlation, peak, at_peak, worst;
};

AxisErrors CompareAxis(const Eigen::ArrayXd& estimated, const Eigen::ArrayXd& measured) {
  const Eigen::ArrayXd error = estimated - measured;
  const Eigen::ArrayXd e = estimated - estimated.mean(), m = measured - measured.mean();
  const double mse = error.square().mean(), variance = m.square().mean();
  const double spread = std::sqrt(e.square().mean() * variance);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  Eigen::Index at = 0;
  const double peak = measured.abs().maxCoeff(&at);
  return {std::sqrt(mse),
          variance > 0 ? mse / variance : kUnknown,
          spread > 0 ? (e * m).mean() / spread : kUnknown,
          peak,
          std::abs(error[at]),
          error.abs().maxCoeff()};
}

Eigen::ArrayXd Axis(std::span<const Eigen::Vector3f> forces, Eigen::Index axis) {
  Eigen::ArrayXd values(static_cast<Eigen::Index>(forces.size()));
  for (std::size_t i = 0; i < forces.size(); ++i) {
    values[static_cast<Eigen::Index>(i)] = static_cast<double>(forces[i][axis]);
  }
  return values;
}

}  // namespace

ForceErrors CompareForces(std::span<const Eigen::Vector3f> estimated,
                          std::span<const Eigen::Vector3f> measured) {
  ForceErrors errors;
  errors.count = measured.size();
  if (measured.empty()) return errors;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const AxisErrors a = CompareAxis(Axis(estimated, axis), Axis(measured, axis));
    errors.rmse[axis] = a.rmse;
    errors.smse[axis] = a.smse;
    errors.correlation[axis] = a.correlation;
    errors.peak[axis] = a.peak;
    errors.at_peak[axis] = a.at_peak;
    errors.worst[axis] = a.worst;
  }
  return errors;
}

}  // namespace palpate
