#include "slave/identify/prediction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "shared/text/text.h"

namespace palpate::identify {
namespace {

constexpr double kGoodFit = 0.04;  // rms over the peak: rubber-like laws are believed
constexpr double kWithin = 2;      // misfit, of the best: laws that are kept
// One sigma of any law beside its data: of the stress, and of the highest that was measured.
constexpr double kOwnError = 0.05, kOwnOfPeak = 0.03;
constexpr double kWide = 1.96;
constexpr std::array kRubberWeights{0.3, 0.45, 0.25};
constexpr int kRows = 40;
constexpr double kSecondStrain = 0.5;  // of the first, in the biaxial test that is predicted [-]

const std::vector<LawFamily>& RubberLike() {
  static const std::vector<LawFamily> families{
      {.name = "yeoh + 0.1 I2", .yeoh = {1, 2, 3}, .second_share = 0.1},
      {.name = "yeoh + 0.4 I2", .yeoh = {1, 2, 3}, .second_share = 0.4},
      {.name = "yeoh + 1.0 I2", .yeoh = {1, 2, 3}, .second_share = 1.0}};
  return families;
}

double FirstInvariant(const Eigen::Matrix3d& F) {
  return F.squaredNorm() / std::cbrt(std::pow(F.determinant(), 2));
}

std::string ComponentName(const MaterialTest& test, std::size_t component) {
  const auto [i, j] = test.components[component];
  return Formatted("%s%d%d", test.cauchy ? "sigma" : "P", i + 1, j + 1);
}

}  // namespace

Predictor::Predictor(const std::vector<MaterialTest>& tests, bool foam)
    : tests_(tests), foam_(foam), peak_(PeakOf(tests)) {
  if (!foam) AddRubberLike();
  if (members_.empty()) AddOffered();
  if (members_.empty()) throw std::runtime_error("no stable constitutive model fits these tests");
  misfit_ = std::numeric_limits<double>::infinity();
  double sum = 0;
  for (const Member& member : members_) {
    misfit_ = std::min(misfit_, member.fit.rms);
    sum += member.weight;
    words_ += (words_.empty() ? "" : ", ") + member.fit.law.name +
              Formatted(" (%.2g %%)", 100 * member.fit.rms);
  }
  for (Member& member : members_) member.weight /= sum;
}

// Yeoh's laws are here to say how far curves may part, not to be solved with: they may be unstable.
void Predictor::AddRubberLike() {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < RubberLike().size(); ++i) {
    const LawFamily& family = RubberLike()[i];
    if (ValuesOf(tests_) < 2 * static_cast<std::size_t>(family.parameters())) continue;
    LawFit fit = FitLaw(family, tests_);
    if (!(fit.law.ShearModulus() > 0)) continue;
    best = std::min(best, fit.rms);
    members_.push_back({std::move(fit), kRubberWeights[i]});
  }
  if (best > kGoodFit) members_.clear();
}

void Predictor::AddOffered() {
  double best = std::numeric_limits<double>::infinity();
  std::vector<LawFit> fits = FitLaws(tests_, foam_);
  std::erase_if(fits,
                [](const LawFit& fit) { return !fit.unstable.empty() || fit.law.terms.empty(); });
  for (const LawFit& fit : fits) best = std::min(best, fit.rms);
  for (LawFit& fit : fits) {
    if (fit.rms <= kWithin * best + 1e-3) members_.push_back({std::move(fit), 1});
  }
}

PredictedRow Predictor::At(const MaterialTest& test, std::size_t row, std::size_t component) const {
  MaterialTest one = test;
  one.rows = {test.rows[row]};
  const auto c = static_cast<Eigen::Index>(component);
  double mean = 0, square = 0, own = 0;
  for (const Member& member : members_) {
    const double stress = Predict(member.fit.law, one, 0)[c];
    const double half = PredictionHalfWidths(member.fit, one)[c] / kWide;
    mean += member.weight * stress;
    square += member.weight * stress * stress;
    own += member.weight * half * half;
  }
  const double between = std::max(0.0, square - mean * mean);
  const double law = std::hypot(kOwnError * mean, kOwnOfPeak * peak_),
               misfit = misfit_ * std::max(std::abs(mean), 0.1 * peak_);
  const double half = kWide * std::sqrt(between + own + law * law + misfit * misfit);
  return {AbscissaOf(test, test.rows[row], component), mean, mean - half, mean + half,
          std::nullopt};
}

MaterialTest Predictor::Reached(TestKind kind) const {
  double reach = 3;
  for (const MaterialTest& test : tests_) {
    for (const TestRow& row : test.rows) {
      reach = std::max(reach, FirstInvariant(DeformationOf(test, row, std::nullopt)));
    }
  }
  const std::optional<double> nu = members_.front().fit.law.nu;
  const auto [low, high] = StretchRange(tests_, nu);
  MaterialTest test{.kind = kind, .components = {{0, 0}}};
  if (kind == TestKind::kShear) test.components = {{0, 1}};
  const double rest = kind == TestKind::kShear ? 0 : 1;
  const auto within = [&](const TestRow& row) {
    const Eigen::Matrix3d F = DeformationOf(test, row, nu);
    if (!foam_) return FirstInvariant(F) <= reach;
    const Eigen::Vector3d l = Eigen::JacobiSVD<Eigen::Matrix3d>(F).singularValues();
    return l.minCoeff() >= low && l.maxCoeff() <= high;
  };
  // Only a foam is also compressed: what is incompressible then deforms as in another tension.
  for (const double step : foam_&& rest > 0 ? std::vector{-0.01, 0.01} : std::vector{0.01}) {
    for (TestRow row{.abscissa = rest, .measured = {0}}; test.rows.size() < 400;) {
      if (!within(row)) break;
      test.rows.push_back(row);
      row.abscissa += step;
      row.across = 1 + kSecondStrain * (row.abscissa - 1);
    }
    if (step < 0) std::ranges::reverse(test.rows), test.rows.pop_back();
  }
  return test;
}

std::vector<PredictedCurve> Predictor::OtherTests() const {
  std::array<bool, 7> known{};
  for (const MaterialTest& test : tests_) known[static_cast<std::size_t>(test.kind)] = true;
  std::vector<PredictedCurve> curves;
  for (const TestKind kind : {TestKind::kUniaxial, TestKind::kEquibiaxial, TestKind::kPlanar,
                              TestKind::kShear, TestKind::kBiaxial}) {
    if (known[static_cast<std::size_t>(kind)]) continue;
    const MaterialTest test = Reached(kind);
    PredictedCurve curve{kind, std::string(NameOf(kind)), ComponentName(test, 0), {}};
    if (kind == TestKind::kBiaxial) curve.name += Formatted(":%g", kSecondStrain);
    for (std::size_t i = 0; i < test.rows.size(); i += 1 + test.rows.size() / kRows) {
      curve.rows.push_back(At(test, i));
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

std::vector<PredictedCurve> Predictor::FittedTests() const {
  std::vector<PredictedCurve> curves;
  for (const MaterialTest& test : tests_) {
    for (std::size_t c = 0; c < test.components.size(); ++c) {
      PredictedCurve curve{test.kind, test.name, ComponentName(test, c), {}};
      for (std::size_t i = 0; i < test.rows.size(); ++i) {
        curve.rows.push_back(At(test, i, c));
        curve.rows.back().measured = test.rows[i].measured[c];
      }
      curves.push_back(std::move(curve));
    }
  }
  return curves;
}

}  // namespace palpate::identify
