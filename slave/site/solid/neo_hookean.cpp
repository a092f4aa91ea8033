#include "slave/site/solid/neo_hookean.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace palpate::site {
namespace {

using Eigen::Matrix3d;

Matrix3d CofactorOf(const Matrix3d& F) {
  Matrix3d cofactor;
  cofactor << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return cofactor;
}

// Where a rising function is zero.
template <typename Function>
double RootOf(double low, double high, const Function& function) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (function(middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

NeoHookean::NeoHookean(double nu, double tension)
    : mu_(0.5 / (1 + nu)), bulk_(1 / (3 * (1 - 2 * nu))) {
  if (tension == 0) return;
  const auto across = [&](double along) {
    return RootOf(0.01, 10, [&](double x) { return Stretched(along, x, 2); });
  };
  const double along = RootOf(1, 4, [&](double x) { return Stretched(x, across(x), 0) - tension; });
  stretch_ << along, along, across(along);
}

// Cauchy stress of a sheet.
double NeoHookean::Stretched(double along, double across, int component) const {
  const Eigen::Vector3d stretch(along, along, across);
  Stress stress;
  FromFree(Matrix3d((stretch.array() - 1).matrix().asDiagonal()), false, &stress);
  return stress.P(component, component) * stretch[component] / stretch.prod();
}

bool NeoHookean::At(const Matrix3d& H, bool with_tangent, Stress* stress) const {
  Matrix3d from_free = H * stretch_.asDiagonal();
  from_free.diagonal().array() += stretch_.array() - 1;
  if (!FromFree(from_free, with_tangent, stress)) return false;
  const double volume = stretch_.prod();
  stress->P = stress->P * stretch_.asDiagonal() / volume;
  if (!with_tangent) return true;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      stress->tangent.block<3, 3>(3 * i, 3 * j) *= stretch_[i] * stretch_[j] / volume;
    }
  }
  return true;
}

// With G = F^-T, c = mu J^(-2/3) and q = K J (J - 1),
//
//   P = c (F - tr(F^T F) / 3 G) + q G
//   dP_ai / dF_bj = c (d_ab d_ij - 2/3 (F_ai G_bj + G_ai F_bj)) + (c tr / 3 - q) G_aj G_bi
//                   + (2/9 c tr + K J (2 J - 1)) G_ai G_bj
bool NeoHookean::FromFree(const Matrix3d& H, bool with_tangent, Stress* stress) const {
  const Matrix3d minors = CofactorOf(H);
  const Matrix3d area = H.trace() * Matrix3d::Identity() - H.transpose() + minors;  // cof F - I
  const double volume = H.trace() + minors.trace() + H.determinant();               // J - 1
  const double stretch = 2 * H.trace() + H.squaredNorm();                           // tr F^T F - 3
  const double J = 1 + volume;
  if (!(J > 0)) return false;
  const Matrix3d F = Matrix3d::Identity() + H, G = (Matrix3d::Identity() + area) / J;
  const double c = mu_ / std::cbrt(J * J), q = bulk_ * J * volume, trace = 3 + stretch;
  stress->P = c / J * (H - area + volume * F - stretch / 3 * (Matrix3d::Identity() + area)) + q * G;
  if (!with_tangent) return true;
  const auto f = F.reshaped(), g = G.reshaped();
  stress->tangent = (2 * c * trace / 9 + bulk_ * J * (2 * J - 1)) * g * g.transpose() -
                    2 * c / 3 * (f * g.transpose() + g * f.transpose());
  stress->tangent.diagonal().array() += c;
  const double crossed = c * trace / 3 - q;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      stress->tangent.block<3, 3>(3 * i, 3 * j) += crossed * G.col(j) * G.col(i).transpose();
    }
  }
  return true;
}

}  // namespace palpate::site
