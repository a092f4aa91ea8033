#include "slave/mechanics/fem/solid/ogden_law.h"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// e^x - 1 - x, with all its digits where x is small.
double BeyondLinear(double x) {
  if (std::abs(x) > 1e-2) return std::expm1(x) - x;
  return x * x * (1.0 / 2 + x * (1.0 / 6 + x * (1.0 / 24 + x * (1.0 / 120 + x / 720))));
}

Vector3d WithoutMean(const Vector3d& v) {
  return v.array() - v.mean();
}

}  // namespace

OgdenLaw::OgdenLaw(const std::vector<OgdenTerm>& terms, double mu) {
  for (const OgdenTerm& term : terms) terms_.push_back({term.share * mu, term.exponent});
}

Vector3d OgdenLaw::Kirchhoff(const Vector3d& log_b) const {
  Vector3d sum = Vector3d::Zero();
  for (const Term& term : terms_) {
    const Vector3d power = (term.alpha * log_b).unaryExpr([](double x) { return std::expm1(x); });
    sum += 2 * term.mu / term.alpha * WithoutMean(power);
  }
  return sum;
}

// Uses C - I = H + H^T + H^T H, so that small eigenvalues keep their digits.
OgdenLaw::Point OgdenLaw::At(const Matrix3d& H) const {
  Point point;
  const Matrix3d F = Matrix3d::Identity() + H;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(H + H.transpose() + H.transpose() * H);
  const Vector3d& e = eigen.eigenvalues();
  if (!(F.determinant() > 0) || !(e[0] > -1)) {
    point.energy = std::numeric_limits<double>::infinity();
    return point;
  }
  const Vector3d log_b = WithoutMean(0.5 * e.unaryExpr([](double x) { return std::log1p(x); }));
  for (const Term& term : terms_) {
    const Vector3d beyond = (term.alpha * log_b).unaryExpr(&BeyondLinear);
    point.energy += 2 * term.mu / (term.alpha * term.alpha) * beyond.sum();
  }
  const Vector3d second_piola = Kirchhoff(log_b).cwiseQuotient(Vector3d(e.array() + 1));
  const Matrix3d& V = eigen.eigenvectors();
  point.stress = F * V * second_piola.asDiagonal() * V.transpose();
  return point;
}

OgdenLaw::Principal OgdenLaw::At(const Vector3d& stretches) const {
  const Vector3d log_b = WithoutMean(stretches.array().log());
  const Vector3d kirchhoff = Kirchhoff(log_b);
  Matrix3d by_log = Matrix3d::Zero();  // of Kirchhoff's stresses
  for (const Term& term : terms_) {
    const Vector3d power = (term.alpha * log_b).array().exp();
    by_log += 2 * term.mu * Matrix3d(power.asDiagonal());
    by_log.colwise() -= 2 * term.mu / 3 * power;
    by_log.rowwise() -= 2 * term.mu / 3 * WithoutMean(power).transpose();
  }
  by_log.diagonal() -= kirchhoff;
  const Vector3d inverse = stretches.cwiseInverse();
  return {kirchhoff.cwiseProduct(inverse), inverse.asDiagonal() * by_log * inverse.asDiagonal()};
}

}  // namespace palpate
