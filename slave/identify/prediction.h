// Prediction of other tests by a constitutive model that was fitted to some tests, with its
// uncertainty.
#pragma once

#include <string>
#include <vector>

#include "slave/identify/law_fit.h"

namespace palpate::identify {

struct PredictedRow {
  double abscissa = 0;                   // stretch or amount of shear
  double stress = 0, low = 0, high = 0;  // nominal, band of 95 % [Pa]
};
struct PredictedCurve {
  TestKind kind = TestKind::kUniaxial;
  std::string name;
  std::vector<PredictedRow> rows;
};

// Uniaxial tests determine how W depends on the first invariant, but hardly on the second: models
// of equal fit differ elsewhere by any amount. The assumption made instead: rubber-like solids
// carry between a tenth and all of their initial modulus by the second invariant (Yeoh's model with
// a term of Gent and Thomas; Treloar 1975, ch. 10), and no model with so few constants is better
// than some per cent. If no such model fits (tissue, which is stiffer in compression), stable Ogden
// models are used. The band is the difference of these models, the covariance of the constants and
// the models' own error, together at 95 %.
class Predictor {
 public:
  // Throws std::runtime_error as FitLaw.
  explicit Predictor(const std::vector<MaterialTest>& tests);

  [[nodiscard]] PredictedRow At(const MaterialTest& test, std::size_t row) const;
  // Tests of the other kinds as far as the invariants of the fitted ones reach.
  [[nodiscard]] std::vector<PredictedCurve> OtherTests() const;
  // Description with the quality of the fit.
  [[nodiscard]] const std::string& laws() const { return words_; }

 private:
  struct Member {
    const LawFamily* family = nullptr;
    LawFit fit;
    double weight = 0;
  };
  void Add(const std::vector<LawFamily>& families, const std::vector<double>& weights);

  std::vector<MaterialTest> tests_;
  std::vector<LawFamily> families_;
  std::vector<Member> members_;
  double misfit_ = 0, peak_ = 0;  // of the fit [-]; [Pa]
  std::string words_;
};

}  // namespace palpate::identify
