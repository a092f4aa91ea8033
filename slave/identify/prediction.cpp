#include "slave/identify/prediction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "shared/text/text.h"

namespace palpate::identify {
namespace {

constexpr double kGoodFit = 0.04;  // rms over the peak: rubber-like laws are believed
constexpr double kWithin = 2;      // misfit, of the best: laws that are kept
// One sigma of any law beside its data: of the stress, and of the highest that was measured.
constexpr double kOwnError = 0.05, kOwnOfPeak = 0.03;
constexpr double kWide = 1.96;
constexpr int kRows = 40;

const std::vector<LawFamily>& RubberLike() {
  static const std::vector<LawFamily> families{
      {.name = "yeoh + 0.1 I2", .yeoh = true, .second_share = 0.1},
      {.name = "yeoh + 0.4 I2", .yeoh = true, .second_share = 0.4},
      {.name = "yeoh + 1.0 I2", .yeoh = true, .second_share = 1.0}};
  return families;
}

double FirstInvariant(const MaterialTest& test, const HyperLaw& law, double abscissa) {
  return PrincipalStretches(test.kind, abscissa, law.nu).squaredNorm();
}

MaterialTest Empty(TestKind kind) {
  MaterialTest test{.kind = kind, .components = {{0, 0}}};
  if (kind == TestKind::kShear) test.components = {{0, 1}};
  return test;
}

}  // namespace

Predictor::Predictor(const std::vector<MaterialTest>& tests) : tests_(tests), peak_(PeakOf(tests)) {
  Add(RubberLike(), {0.3, 0.45, 0.25});
  if (members_.empty()) {
    std::vector<LawFamily> stable;
    for (const LawFamily& family : OfferedLaws()) {
      if (!family.foam && !family.yeoh) stable.push_back(family);
    }
    Add(stable, std::vector<double>(stable.size(), 1));
  }
  if (members_.empty()) throw std::runtime_error("no stable constitutive model fits these tests");
}

void Predictor::Add(const std::vector<LawFamily>& families, const std::vector<double>& weights) {
  families_ = families;
  const bool must_fit = families.front().yeoh;
  std::vector<Member> all;
  for (std::size_t i = 0; i < families_.size(); ++i) {
    if (ValuesOf(tests_) < 2 * static_cast<std::size_t>(families_[i].parameters())) continue;
    Member member{&families_[i], FitLaw(families_[i], tests_), weights[i]};
    // Yeoh's laws are here to say how far curves may part, not to be solved with.
    if (member.fit.law.ShearModulus() > 0 && (must_fit || member.fit.unstable.empty())) {
      all.push_back(std::move(member));
    }
  }
  if (all.empty()) return;
  const double best = std::ranges::min(all, {}, [](const Member& m) { return m.fit.rms; }).fit.rms;
  if (must_fit && best > kGoodFit) return;
  double sum = 0;
  for (Member& member : all) {
    if (!must_fit && member.fit.rms > kWithin * best + 1e-3) continue;
    sum += member.weight;
    words_ += (words_.empty() ? "" : ", ") + member.fit.law.name +
              Formatted(" (%.2g %%)", 100 * member.fit.rms);
    members_.push_back(std::move(member));
  }
  misfit_ = best;
  for (Member& member : members_) member.weight /= sum;
}

PredictedRow Predictor::At(const MaterialTest& test, std::size_t row) const {
  MaterialTest one = test;
  one.rows = {test.rows[row]};
  double mean = 0, square = 0, own = 0;
  for (const Member& member : members_) {
    const double stress = Predict(member.fit.law, one, 0)[0];
    const double half = PredictionHalfWidth(*member.family, member.fit, one) / kWide;
    mean += member.weight * stress;
    square += member.weight * stress * stress;
    own += member.weight * half * half;
  }
  const double between = std::max(0.0, square - mean * mean);
  const double law = std::hypot(kOwnError * mean, kOwnOfPeak * peak_),
               misfit = misfit_ * std::max(std::abs(mean), 0.1 * peak_);
  const double half = kWide * std::sqrt(between + own + law * law + misfit * misfit);
  return {test.rows[row].abscissa, mean, mean - half, mean + half};
}

std::vector<PredictedCurve> Predictor::OtherTests() const {
  double reach = 3;
  std::array<bool, 7> known{};
  for (const MaterialTest& test : tests_) {
    known[static_cast<std::size_t>(test.kind)] = true;
    for (const TestRow& row : test.rows) {
      reach = std::max(reach, FirstInvariant(test, {}, row.abscissa));
    }
  }
  std::vector<PredictedCurve> curves;
  for (const TestKind kind :
       {TestKind::kUniaxial, TestKind::kEquibiaxial, TestKind::kPlanar, TestKind::kShear}) {
    if (known[static_cast<std::size_t>(kind)]) continue;
    MaterialTest test = Empty(kind);
    const double rest = kind == TestKind::kShear ? 0 : 1;
    for (double x = rest; FirstInvariant(test, {}, x) <= reach && test.rows.size() < 400;
         x += 0.01) {
      test.rows.push_back({.abscissa = x, .measured = {0}});
    }
    PredictedCurve curve{kind, std::string(NameOf(kind)), {}};
    for (std::size_t i = 0; i < test.rows.size(); i += 1 + test.rows.size() / kRows) {
      curve.rows.push_back(At(test, i));
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace palpate::identify
