#include "slave/identify/material_test.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "shared/text/text.h"

namespace palpate::identify {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

VectorXd Stacked(const std::vector<MaterialTest>& tests, const auto& of) {
  VectorXd all(static_cast<Eigen::Index>(ValuesOf(tests)));
  Eigen::Index at = 0;
  for (const MaterialTest& test : tests) {
    const VectorXd values = of(test);
    all.segment(at, values.size()) = values;
    at += values.size();
  }
  return all;
}

// Nominal stress; the third direction is free.
Matrix3d Nominal(const HyperLaw& law, const Matrix3d& F) {
  Matrix3d P;
  if (F.isDiagonal(0)) {  // most tests: without a decomposition ten times as fast
    P = law.Derivatives(F.diagonal()).asDiagonal();
  } else {
    const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    P = svd.matrixU() * law.Derivatives(svd.singularValues()).asDiagonal() *
        svd.matrixV().transpose();
  }
  const Matrix3d cofactor = F.inverse().transpose();
  return P - P(2, 2) / cofactor(2, 2) * cofactor;
}

}  // namespace

Vector3d PrincipalStretches(TestKind kind, double stretch, double across) {
  switch (kind) {
    case TestKind::kUniaxial: {
      const double free = std::pow(stretch, -0.5);
      return {stretch, free, free};
    }
    case TestKind::kEquibiaxial:
      return {stretch, stretch, 1 / (stretch * stretch)};
    case TestKind::kPlanar:
      return {stretch, 1, 1 / stretch};
    case TestKind::kBiaxial:
      return {stretch, across, 1 / (stretch * across)};
    case TestKind::kShear: {
      const double half = stretch / 2, root = std::sqrt(1 + half * half);
      return {root + half, root - half, 1};
    }
    default:
      return {1, 1, 1};
  }
}

Matrix3d DeformationOf(const MaterialTest& test, const TestRow& row) {
  if (test.kind == TestKind::kTensor) return row.F;
  if (test.kind == TestKind::kShear) {
    Matrix3d F = Matrix3d::Identity();
    F(0, 1) = row.abscissa;
    return F;
  }
  return PrincipalStretches(test.kind, row.abscissa, row.across).asDiagonal();
}

double MaterialTest::Peak() const {
  double peak = 0;
  for (const TestRow& row : rows) {
    for (const double value : row.measured) peak = std::max(peak, std::abs(value));
  }
  return peak;
}

VectorXd Predict(const HyperLaw& law, const MaterialTest& test, std::size_t index) {
  const Matrix3d F = DeformationOf(test, test.rows[index]);
  Matrix3d stress = test.end_factor * Nominal(law, F);
  if (test.cauchy) stress = stress * F.transpose() / F.determinant();
  VectorXd stresses(static_cast<Eigen::Index>(test.components.size()));
  for (std::size_t c = 0; c < test.components.size(); ++c) {
    stresses[static_cast<Eigen::Index>(c)] =
        stress(test.components[c].first, test.components[c].second);
  }
  return stresses;
}

VectorXd Predict(const HyperLaw& law, const MaterialTest& test) {
  const auto count = static_cast<Eigen::Index>(test.components.size());
  VectorXd all(static_cast<Eigen::Index>(test.values()));
  for (std::size_t i = 0; i < test.rows.size(); ++i) {
    all.segment(static_cast<Eigen::Index>(i) * count, count) = Predict(law, test, i);
  }
  return all;
}

VectorXd Measured(const MaterialTest& test) {
  VectorXd all(static_cast<Eigen::Index>(test.values()));
  Eigen::Index at = 0;
  for (const TestRow& row : test.rows) {
    for (const double value : row.measured) all[at++] = value;
  }
  return all;
}

VectorXd Predict(const HyperLaw& law, const std::vector<MaterialTest>& tests) {
  return Stacked(tests, [&](const MaterialTest& test) { return Predict(law, test); });
}

VectorXd Measured(const std::vector<MaterialTest>& tests) {
  return Stacked(tests, [](const MaterialTest& test) { return Measured(test); });
}

std::size_t ValuesOf(const std::vector<MaterialTest>& tests) {
  std::size_t count = 0;
  for (const MaterialTest& test : tests) count += test.values();
  return count;
}

double PeakOf(const std::vector<MaterialTest>& tests) {
  double peak = 0;
  for (const MaterialTest& test : tests) peak = std::max(peak, test.Peak());
  return peak;
}

std::string AgainstIsotropy(const MaterialTest& test) {
  constexpr double kAlike = 0.01, kStrained = 0.05, kOtherwise = 0.1;
  const std::vector<std::pair<int, int>> both{{0, 0}, {1, 1}};
  if (test.components != both) return {};
  for (const TestRow& row : test.rows) {
    const Matrix3d F = DeformationOf(test, row);
    const bool alike = F.isDiagonal(0) && std::abs(F(0, 0) - F(1, 1)) < kAlike * F(0, 0);
    const double apart = std::abs(row.measured[0] - row.measured[1]);
    if (!alike || std::abs(F(0, 0) - 1) < kStrained || apart < kOtherwise * test.Peak()) continue;
    return Formatted(
        "%s: the stretch is %.4g in both directions, but the stresses are %.4g and %.4g Pa: not "
        "isotropic; if the second stretch differs, use planar or biaxial:RATIO",
        test.name.c_str(), F(0, 0), row.measured[0], row.measured[1]);
  }
  return {};
}

double LargestStrain(const MaterialTest& test, const TestRow& row) {
  const Vector3d l = Eigen::JacobiSVD<Matrix3d>(DeformationOf(test, row)).singularValues();
  return std::max(l.maxCoeff() - 1, 1 - l.minCoeff());
}

std::pair<double, double> StretchRange(const std::vector<MaterialTest>& tests) {
  std::pair<double, double> range{1, 1};
  for (const MaterialTest& test : tests) {
    for (const TestRow& row : test.rows) {
      const Vector3d l = Eigen::JacobiSVD<Matrix3d>(DeformationOf(test, row)).singularValues();
      range = {std::min(range.first, l.minCoeff()), std::max(range.second, l.maxCoeff())};
    }
  }
  return range;
}

std::pair<double, double> LinearRange(const HyperLaw& law) {
  constexpr double kStrainStep = 0.005, kTenth = 0.1, kMinStretchStrain = -0.9,
                   kMaxStretchStrain = 1;
  MaterialTest one{.kind = TestKind::kUniaxial, .components = {{0, 0}}, .rows = {{}}};
  const auto linear = [&](double strain) {
    one.rows[0].abscissa = 1 + strain;
    return std::abs(law.YoungModulus() * strain / Predict(law, one, 0)[0] - 1) <= kTenth;
  };
  std::pair<double, double> range{0, 0};
  while (range.first > kMinStretchStrain && linear(range.first - kStrainStep))
    range.first -= kStrainStep;
  while (range.second < kMaxStretchStrain && linear(range.second + kStrainStep))
    range.second += kStrainStep;
  return range;
}

}  // namespace palpate::identify
