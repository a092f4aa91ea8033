#include "slave/mechanics/fem/solid/material_law.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMinStretchSum = 1e-9;   // below this a rotation is not defined
constexpr double kMinStretch = 1e-3;      // of Ogden's tangent
constexpr double kEqualStretches = 1e-6;  // relative: their quotient becomes a derivative

Matrix3d CofactorOf(const Matrix3d& F) {
  Matrix3d cofactor;
  cofactor << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return cofactor;
}

// First axis of plane i, which contains the other two axes.
constexpr int First(int plane) {
  return (plane + 1) % 3;
}
constexpr int Second(int plane) {
  return (plane + 2) % 3;
}

// S - I = (C - I) (S + I)^-1 with C - I from the displacement gradient: small strains keep all
// their digits.
Matrix3d StretchMinusIdentity(const Matrix3d& H, const SignedSvd& svd) {
  if (svd.s[2] <= 0) {
    const Vector3d stretch = svd.s.array() - 1;
    return svd.V * stretch.asDiagonal() * svd.V.transpose();
  }
  const Matrix3d C_minus_I = H + H.transpose() + H.transpose() * H;
  const Vector3d inverse = (svd.s.array() + 1).inverse();
  const Matrix3d stretch = C_minus_I * svd.V * inverse.asDiagonal() * svd.V.transpose();
  return 0.5 * (stretch + stretch.transpose());
}

Vector3d WithoutNegative(const Vector3d& v, double removed) {
  return v.cwiseMax(0) + (1 - removed) * v.cwiseMin(0);
}

double CompressibilityOf(FemOptions::Law law, double nu) {
  switch (law) {
    case FemOptions::Law::kNeoHookean:
      return 12 * (1 + nu) * (1 - 2 * nu) / (5 + 2 * nu);
    case FemOptions::Law::kOgden:
      return 3 * (1 - 2 * nu);
    default:
      return (1 + nu) * (1 - 2 * nu) / nu;
  }
}

// Removes a fraction of every negative eigenvalue.
Matrix3d WithoutNegative(const Matrix3d& m, double removed) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(m);
  if (eigen.eigenvalues().minCoeff() >= 0) return m;
  const Vector3d kept = WithoutNegative(Vector3d(eigen.eigenvalues()), removed);
  return eigen.eigenvectors() * kept.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

SignedSvd SignedSvdOf(const Matrix3d& F) {
  const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  SignedSvd signed_svd{svd.matrixU(), svd.matrixV(), svd.singularValues()};
  if (signed_svd.U.determinant() < 0) {
    signed_svd.U.col(2) *= -1;
    signed_svd.s[2] *= -1;
  }
  if (signed_svd.V.determinant() < 0) {
    signed_svd.V.col(2) *= -1;
    signed_svd.s[2] *= -1;
  }
  return signed_svd;
}

MaterialLaw::MaterialLaw(FemOptions::Law law, double nu, const std::vector<OgdenTerm>& terms)
    : law_(law),
      mu_(0.5 / (1 + nu)),
      compressibility_(CompressibilityOf(law, nu)),
      ogden_(terms, mu_) {}

MaterialLaw::Point MaterialLaw::At(const Matrix3d& H) const {
  Point point;
  switch (law_) {
    case FemOptions::Law::kLinear: {
      const Matrix3d strain = 0.5 * (H + H.transpose());
      point.energy = mu_ * strain.squaredNorm();
      point.g = strain.trace();
      point.stress = 2 * mu_ * strain;
      point.volume_stress.setIdentity();
      break;
    }
    case FemOptions::Law::kCorotational: {
      const SignedSvd svd = SignedSvdOf(Matrix3d::Identity() + H);
      const Matrix3d stretch = StretchMinusIdentity(H, svd);
      point.energy = mu_ * stretch.squaredNorm();
      point.g = stretch.trace();
      point.volume_stress.noalias() = svd.U * svd.V.transpose();
      point.stress = 2 * mu_ * point.volume_stress * stretch;
      break;
    }
    case FemOptions::Law::kNeoHookean: {
      const double m = 4.0 / 3 * mu_;
      const Matrix3d minors = CofactorOf(H);
      const double stretch = 2 * H.trace() + H.squaredNorm();                           // I_C - 3
      const Matrix3d area = H.trace() * Matrix3d::Identity() - H.transpose() + minors;  // cof F - I
      point.g = H.trace() + minors.trace() + H.determinant();
      point.energy = 0.5 * m * (stretch - std::log1p(stretch / 4)) - 0.75 * m * point.g;
      point.volume_stress = Matrix3d::Identity() + area;
      point.stress =
          0.75 * m * (H - area) + m * stretch / (4 * (stretch + 4)) * (Matrix3d::Identity() + H);
      break;
    }
    case FemOptions::Law::kOgden: {
      const OgdenLaw::Point isochoric = ogden_.At(H);
      const Matrix3d minors = CofactorOf(H);
      point.energy = isochoric.energy;
      point.stress = isochoric.stress;
      point.g = H.trace() + minors.trace() + H.determinant();
      point.volume_stress = (1 + H.trace()) * Matrix3d::Identity() - H.transpose() + minors;
      break;
    }
  }
  return point;
}

// Part of the general form for isotropic laws (Ogden 1984, 6.1): the stiffness against a shear
// between two axes is the difference quotient of their stresses, that against a rotation uses their
// sum.
MaterialLaw::Principal MaterialLaw::OgdenPrincipalAt(const Vector3d& stretches, double p,
                                                     double bulk) const {
  const Vector3d s = stretches.cwiseMax(kMinStretch);
  const auto [slope, curvature] = ogden_.At(s);
  const Vector3d area(s[1] * s[2], s[0] * s[2], s[0] * s[1]);
  Principal principal;
  principal.along = curvature + bulk * area * area.transpose();
  for (int i = 0; i < 3; ++i) {
    const int a = First(i), b = Second(i);
    principal.along(a, b) += p * s[i];
    principal.along(b, a) += p * s[i];
    const double gap = s[a] - s[b], sum = s[a] + s[b];
    const double shear = std::abs(gap) < kEqualStretches * sum
                             ? 0.5 * (curvature(a, a) + curvature(b, b)) - curvature(a, b)
                             : (slope[a] - slope[b]) / gap;
    principal.flip[i] = shear - p * s[i];
    principal.twist[i] = (slope[a] + slope[b]) / sum + p * s[i];
  }
  return principal;
}

MaterialLaw::Principal MaterialLaw::PrincipalAt(const Vector3d& s, double p, double bulk,
                                                const Tangent& tangent) const {
  Principal principal;
  if (law_ == FemOptions::Law::kCorotational) {
    principal.along = 2 * mu_ * Matrix3d::Identity() + Matrix3d::Constant(bulk);
    principal.flip.setConstant(2 * mu_);
    for (int i = 0; i < 3; ++i) {
      const double sum = std::max(s[First(i)] + s[Second(i)], kMinStretchSum);
      principal.twist[i] = 2 * mu_ + 2 * (p - 2 * mu_) / sum;
    }
    if (tangent.warped) principal.twist.setZero();
    return principal;
  }
  if (law_ == FemOptions::Law::kOgden) return OgdenPrincipalAt(s, p, bulk);
  const double m = 4.0 / 3 * mu_;
  const double invariant = s.squaredNorm() + 1;
  const double stretch = m * (1 - 1 / invariant);
  const double pressure = p - 0.75 * m;
  const Vector3d area(s[1] * s[2], s[0] * s[2], s[0] * s[1]);
  principal.along = stretch * Matrix3d::Identity() +
                    2 * m / (invariant * invariant) * s * s.transpose() +
                    bulk * area * area.transpose();
  for (int i = 0; i < 3; ++i) {
    principal.along(First(i), Second(i)) += pressure * s[i];
    principal.along(Second(i), First(i)) += pressure * s[i];
    principal.flip[i] = stretch - pressure * s[i];
    principal.twist[i] = stretch + pressure * s[i];
  }
  return principal;
}

Matrix9d MaterialLaw::LinearTangent(double bulk) const {
  Matrix9d D = mu_ * Matrix9d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      D(i + 3 * j, j + 3 * i) += mu_;
      D(4 * i, 4 * j) += bulk;
    }
  }
  return D;
}

MaterialLaw::InvariantTangent MaterialLaw::InvariantTangentAt(const Matrix3d& H, double p,
                                                              double bulk) const {
  const double m = 4.0 / 3 * mu_;
  const double invariant = 4 + 2 * H.trace() + H.squaredNorm();  // I_C + 1
  return {m * (1 - 1 / invariant), 2 * m / (invariant * invariant), bulk, p - 0.75 * m};
}

Matrix9d MaterialLaw::TangentAt(const Matrix3d& H, double p, double bulk,
                                const Tangent& tangent) const {
  if (law_ == FemOptions::Law::kLinear) return LinearTangent(bulk);
  const SignedSvd svd = SignedSvdOf(Matrix3d::Identity() + H);
  Principal principal = PrincipalAt(svd.s, p, bulk, tangent);
  if (tangent.removed > 0) {
    principal.along = WithoutNegative(principal.along, tangent.removed);
    principal.flip = WithoutNegative(principal.flip, tangent.removed);
    principal.twist = WithoutNegative(principal.twist, tangent.removed);
  }
  Matrix9d D = Matrix9d::Zero();
  Matrix9d W;  // W vec(F) in the principal frame is vec(F) outside
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      D(4 * i, 4 * j) = principal.along(i, j);
      const Matrix3d mode = svd.U.col(i) * svd.V.col(j).transpose();
      W.col(i + 3 * j) = mode.reshaped();
    }
  }
  for (int plane = 0; plane < 3; ++plane) {
    const int a = First(plane) + 3 * Second(plane), b = Second(plane) + 3 * First(plane);
    D(a, a) = D(b, b) = 0.5 * (principal.flip[plane] + principal.twist[plane]);
    D(a, b) = D(b, a) = 0.5 * (principal.flip[plane] - principal.twist[plane]);
  }
  return W * D * W.transpose();
}

}  // namespace palpate
