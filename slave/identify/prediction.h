// Prediction of other tests by a constitutive model that was fitted to some tests, with its
// uncertainty.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slave/identify/law_fit.h"

namespace palpate::identify {

struct PredictedRow {
  double abscissa = 0;                   // stretch or amount of shear
  double stress = 0, low = 0, high = 0;  // with the band of 95 % [Pa]
  std::optional<double> measured;        // of a test that was fitted [Pa]
};
struct PredictedCurve {
  TestKind kind = TestKind::kUniaxial;
  std::string name;
  std::string component;  // of the stress: P11, sigma12
  std::vector<PredictedRow> rows;
};

// Uniaxial tests determine how W depends on the first invariant, but hardly on the second: models
// of equal fit differ elsewhere by any amount. The assumption made instead: rubber-like solids
// carry between a tenth and all of their initial modulus by the second invariant (Yeoh's model with
// a term of Gent and Thomas; Treloar 1975, ch. 10), and no model with so few constants is better
// than some per cent. If no such model fits (tissue, which is stiffer in compression), stable Ogden
// models are used, and of a foam its own ones. The band is the difference of these models, the
// covariance of the constants and the models' own error, together at 95 %.
class Predictor {
 public:
  // `foam`: with compressible models. Throws std::runtime_error as FitLaw.
  explicit Predictor(const std::vector<MaterialTest>& tests, bool foam = false);

  // `component`: index of the test's stress component.
  [[nodiscard]] PredictedRow At(const MaterialTest& test, std::size_t row,
                                std::size_t component = 0) const;
  // Tests of the other kinds as far as the invariants of the fitted ones reach (stretches, of a
  // foam), among them biaxial tension whose second strain is half the first.
  [[nodiscard]] std::vector<PredictedCurve> OtherTests() const;
  // The fitted tests themselves, a curve per component.
  [[nodiscard]] std::vector<PredictedCurve> FittedTests() const;
  // Description with the quality of the fit.
  [[nodiscard]] const std::string& laws() const { return words_; }

 private:
  struct Member {
    LawFit fit;
    double weight = 0;
  };
  void AddRubberLike();
  void AddOffered();
  // The rows of a test of this kind, from rest as far as the fitted tests reach.
  [[nodiscard]] MaterialTest Reached(TestKind kind) const;

  std::vector<MaterialTest> tests_;
  bool foam_ = false;
  std::vector<Member> members_;
  double misfit_ = 0, peak_ = 0;  // of the fit [-]; [Pa]
  std::string words_;
};

}  // namespace palpate::identify
