#include "slave/vision/calibration/pose_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace palpate {
namespace {

double LargestSigma(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

}  // namespace

void PoseNoise::Add(const Jacobian& J, const Covariance& C) {
  normal_ += J.transpose() * J;
  noisy_ += J.transpose() * C * J;
  square_ += J.transpose() * C * C * J;
  trace_ += C.trace();
  square_trace_ += (C * C).trace();
}

PoseNoise::Sigmas PoseNoise::Of(double sum_of_squares) const {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Eigen::FullPivLU<Matrix6> lu(normal_);
  if (!lu.isInvertible()) return {kInfinite, kInfinite};
  const Matrix6 inverse = lu.inverse();
  const Matrix6 taken = inverse * noisy_;  // what the fit takes of the noise
  const double left = trace_ - taken.trace();
  const double left_square =
      square_trace_ - 2 * (inverse * square_).trace() + (taken * taken).trace();
  if (!(left > 1e-9 * trace_) || !(left_square > 0)) return {kInfinite, kInfinite};
  const double widen = StudentOneSigma(left * left / left_square);
  const Matrix6 covariance = widen * widen * sum_of_squares / left * (taken * inverse);
  return {LargestSigma(covariance.topLeftCorner<3, 3>()),
          LargestSigma(covariance.bottomRightCorner<3, 3>())};
}

double StudentOneSigma(double degrees_of_freedom) {
  const double d = degrees_of_freedom;
  return 1 + 1 / (2 * d) + 1 / (4 * d * d) + 1 / (16 * d * d * d);
}

}  // namespace palpate
