#include "slave/identify/hyper_law.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "shared/text/text.h"
#include "slave/identify/material_test.h"

namespace palpate::identify {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kStabilitySteps = 60;  // between rest and the ends of the range
constexpr double kUnstable = -1e-6;  // of the work at rest

// Returns the principal Kirchhoff stresses without pressure, as a function of logarithmic strains.
Vector3d Kirchhoff(const HyperLaw& law, const Vector3d& log_stretch) {
  const Vector3d stretches = log_stretch.array().exp();
  return stretches.cwiseProduct(law.Derivatives(stretches));
}

Matrix3d KirchhoffTangent(const HyperLaw& law, const Vector3d& log_stretch) {
  constexpr double kStep = 1e-5;
  Matrix3d tangent;
  for (int j = 0; j < 3; ++j) {
    const Vector3d step = kStep * Vector3d::Unit(j);
    tangent.col(j) =
        (Kirchhoff(law, log_stretch + step) - Kirchhoff(law, log_stretch - step)) / (2 * kStep);
  }
  return 0.5 * (tangent + tangent.transpose());
}

}  // namespace

Vector3d HyperLaw::Derivatives(const Vector3d& l) const {
  Vector3d slope = Vector3d::Zero();
  for (const LawTerm& term : terms) {
    slope.array() += 2 * term.G / term.alpha * l.array().pow(term.alpha) / l.array();
  }
  const double beyond = l.squaredNorm() - 3;  // I1 - 3
  return slope + 2 * (yeoh[0] + beyond * (2 * yeoh[1] + 3 * beyond * yeoh[2])) * l;
}

double HyperLaw::ShearModulus() const {
  double G = 2 * yeoh[0];
  for (const LawTerm& term : terms) G += term.G;
  return G;
}

double HyperLaw::YoungModulus() const {
  return 3 * ShearModulus();
}

HyperLaw LawFamily::Make(const VectorXd& c, const VectorXd& exponents) const {
  HyperLaw law{.name = name};
  if (!yeoh.empty()) {
    for (Eigen::Index i = 0; i < c.size(); ++i)
      law.yeoh[yeoh[static_cast<std::size_t>(i)] - 1] = c[i];
    return law;
  }
  const auto count = static_cast<Eigen::Index>(fixed.size());
  for (Eigen::Index i = 0; i < c.size(); ++i) {
    double alpha = i < count ? fixed[static_cast<std::size_t>(i)] : exponents[i - count];
    if (std::abs(alpha) < kMinExponent) alpha = std::copysign(kMinExponent, alpha);
    law.terms.push_back({c[i], alpha});
  }
  return law;
}

std::vector<std::string> LawFamily::ParameterNames() const {
  std::vector<std::string> names;
  for (const int power : yeoh) names.push_back("C" + std::to_string(power));
  for (int i = 1; yeoh.empty() && i <= moduli(); ++i) names.push_back("G" + std::to_string(i));
  for (int i = 1; i <= free; ++i) names.push_back("alpha" + std::to_string(i));
  return names;
}

const std::vector<LawFamily>& OfferedLaws() {
  static const std::vector<LawFamily> laws{
      {.name = "neo-hookean", .fixed = {2}}, {.name = "mooney-rivlin", .fixed = {2, -2}},
      {.name = "ogden-1", .free = 1},        {.name = "yeoh", .yeoh = {1, 2, 3}},
      {.name = "ogden-2", .free = 2},        {.name = "ogden-3", .free = 3},
  };
  return laws;
}

double MinStability(const HyperLaw& law, const Vector3d& stretches) {
  const Vector3d log_stretch = stretches.array().log();
  const Matrix3d tangent = KirchhoffTangent(law, log_stretch);
  const double at_rest = 2 * law.ShearModulus();
  if (!tangent.allFinite() || !(at_rest > 0)) return -1;
  Eigen::Matrix<double, 3, 2> isochoric;
  isochoric << 1, 1, -1, 1, 0, -2;
  isochoric.colwise().normalize();
  const Eigen::Matrix2d reduced = isochoric.transpose() * tangent * isochoric;
  const double mean = reduced.trace() / 2, half_difference = (reduced(0, 0) - reduced(1, 1)) / 2;
  return (mean - std::hypot(half_difference, reduced(0, 1))) / at_rest;  // the lesser eigenvalue
}

std::string FirstInstability(const HyperLaw& law, double low, double high) {
  constexpr std::array<std::pair<TestKind, const char*>, 3> kLoads{
      {{TestKind::kUniaxial, "uniaxial load"},
       {TestKind::kEquibiaxial, "equibiaxial load"},
       {TestKind::kPlanar, "planar load"}}};
  for (const auto& [kind, words] : kLoads) {
    for (const double end : {low, high}) {
      for (int i = 0; i <= kStabilitySteps; ++i) {
        const double stretch = std::pow(end, static_cast<double>(i) / kStabilitySteps);
        const Vector3d l = PrincipalStretches(kind, stretch);
        if (MinStability(law, l) > kUnstable) continue;
        return Formatted("unstable from a stretch of %.4g on under %s", stretch, words);
      }
    }
  }
  return {};
}

}  // namespace palpate::identify
