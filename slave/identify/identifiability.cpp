#include "slave/identify/identifiability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "shared/geometry/symmetric_eigen.h"
#include "shared/text/text.h"

namespace palpate::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kStep = 1e-5;      // relative
constexpr double kUntold = 0.5;     // relative sigma of a combination
constexpr double kNamed = 0.35;     // share in it from which a constant is named
constexpr double kNothing = 1e-10;  // of the largest eigenvalue
constexpr double kOpen = 10;        // relative sigma of what is not told at all
constexpr int kRows = 12;           // of a test that is thought of

HyperLaw LawOf(const LawFamily& family, const VectorXd& values) {
  return family.Make(values.head(family.moduli()), values.tail(family.shapes()));
}

// Of a constant that is zero: a modulus is measured by the others, an exponent by one.
VectorXd ScalesOf(const LawFamily& family, const VectorXd& values) {
  VectorXd scales = values.cwiseAbs();
  const double moduli = values.head(family.moduli()).cwiseAbs().maxCoeff();
  for (Index i = 0; i < scales.size(); ++i) {
    if (i >= family.moduli()) {
      scales[i] = std::max(scales[i], 1e-2);
    } else if (scales[i] < 1e-9 * moduli) {
      scales[i] = moduli;
    }
  }
  return scales;
}

MaterialTest Imagined(TestKind kind, double from, double to) {
  MaterialTest test{.kind = kind, .components = {{0, 0}}};
  if (kind == TestKind::kShear) test.components = {{0, 1}};
  for (int i = 1; i <= kRows; ++i) {
    TestRow row{.abscissa = from + (to - from) * i / kRows};
    row.measured = {0};
    test.rows.push_back(row);
  }
  return test;
}

struct Candidate {
  const char* words;
  MaterialTest test;
};

std::vector<Candidate> Candidates(const std::vector<MaterialTest>& tests) {
  const auto [low, high] = StretchRange(tests);
  const double reach = std::max(high, 1 / low);
  const double sheet = std::sqrt(reach);  // beyond, its thickness is out of the range
  return {{"uniaxial tension", Imagined(TestKind::kUniaxial, 1, reach)},
          {"uniaxial compression between lubricated plates",
           Imagined(TestKind::kUniaxial, 1, std::max(0.3, 1 / reach))},
          {"equibiaxial tension", Imagined(TestKind::kEquibiaxial, 1, sheet)},
          {"planar tension", Imagined(TestKind::kPlanar, 1, reach)},
          {"simple shear", Imagined(TestKind::kShear, 0, reach - 1 / reach)}};
}

std::string InWords(const std::vector<std::string>& names, const VectorXd& weak) {
  std::string words;
  double first = 0;
  for (Index i = 0; i < weak.size(); ++i) {
    if (std::abs(weak[i]) < kNamed) continue;
    if (!words.empty()) words += weak[i] * first > 0 ? " with " : " against ";
    if (words.empty()) first = weak[i];
    words += names[static_cast<std::size_t>(i)];
  }
  return words;
}

// Information that one more test of the same relative accuracy gives of the combination.
std::string BestExtra(const LawFamily& family, const VectorXd& values, const VectorXd& direction,
                      const std::vector<MaterialTest>& tests) {
  double best = 0;
  std::string words;
  const HyperLaw law = LawOf(family, values);
  for (const Candidate& candidate : Candidates(tests)) {
    const double peak = Predict(law, candidate.test).cwiseAbs().maxCoeff();
    const VectorXd told = Sensitivities(family, values, {candidate.test}) * direction / peak;
    if (!told.allFinite() || !(told.squaredNorm() > best)) continue;
    best = told.squaredNorm();
    words = candidate.words;
  }
  return words;
}

}  // namespace

MatrixXd Sensitivities(const LawFamily& family, const VectorXd& values,
                       const std::vector<MaterialTest>& tests) {
  const VectorXd scales = ScalesOf(family, values);
  std::vector<VectorXd> columns;
  for (Index i = 0; i < values.size(); ++i) {
    const double step = kStep * scales[i];
    VectorXd up = values, down = values;
    up[i] += step, down[i] -= step;
    columns.emplace_back((Predict(LawOf(family, up), tests) - Predict(LawOf(family, down), tests)) /
                         (2 * step));
  }
  MatrixXd J(columns.front().size(), values.size());
  for (Index i = 0; i < values.size(); ++i) J.col(i) = columns[static_cast<std::size_t>(i)];
  return J;
}

namespace {

// Of J^T J in columns of length one, so that units and sizes of constants play no part.
void Invert(const MatrixXd& J, const VectorXd& scales, Identifiability* told) {
  const VectorXd sizes = J.colwise().norm().transpose().cwiseProduct(scales);
  const VectorXd unit = scales.cwiseQuotient(sizes.cwiseMax(kNothing * sizes.maxCoeff()));
  const MatrixXd even = J * unit.asDiagonal();
  const SymmetricEigen eigen = EigenOf(even.transpose() * even);
  told->inverse = told->open = MatrixXd::Zero(J.cols(), J.cols());
  for (Index i = 0; i < J.cols(); ++i) {
    const VectorXd way = unit.cwiseProduct(VectorXd(eigen.vectors.col(i)));
    if (eigen.values[i] > kNothing * eigen.values.maxCoeff()) {
      told->inverse += way * way.transpose() / eigen.values[i];
    } else {
      const VectorXd open = kOpen / way.cwiseQuotient(scales).cwiseAbs().maxCoeff() * way;
      told->open += open * open.transpose();
    }
  }
}

}  // namespace

Identifiability Identify(const LawFamily& family, const VectorXd& values, const MatrixXd& J,
                         double variance, const std::vector<MaterialTest>& tests) {
  const VectorXd scales = ScalesOf(family, values);
  const MatrixXd relative = J * scales.asDiagonal();
  const SymmetricEigen eigen = EigenOf(relative.transpose() * relative);
  Identifiability told;
  Invert(J, scales, &told);
  const VectorXd weak = eigen.vectors.col(0);
  const double sigma = std::sqrt(variance / std::max(eigen.values[0], 1e-300));
  if (sigma < kUntold) return told;
  told.untold =
      InWords(family.ParameterNames(), weak) +
      (sigma > 1e3 ? std::string(" (undetermined)") : Formatted(" (sigma %.0f %%)", 100 * sigma));
  told.extra = BestExtra(family, values, scales.cwiseProduct(weak), tests);
  return told;
}

}  // namespace palpate::identify
