// What a law that was fitted on some tests says of others, and how sure that is.
#pragma once

#include <string>
#include <vector>

#include "slave/identify/law_fit.h"

namespace palpate::identify {

struct PredictedRow {
  double abscissa = 0, across = 1;       // stretch or amount of shear, second stretch
  double stress = 0, low = 0, high = 0;  // nominal, band of 95 % [Pa]
};
struct PredictedCurve {
  TestKind kind = TestKind::kUniaxial;
  std::string name;
  std::vector<PredictedRow> rows;
};

// Uniaxial tests alone tell how W goes with the first invariant and hardly anything of the second:
// laws of equal fit differ by any amount elsewhere. What is assumed instead is said here:
// rubber-like solids carry between a tenth and the whole of their modulus at rest more by the
// second invariant (Yeoh's law with a term of Gent and Thomas; Treloar 1975, ch. 10), and no law of
// so few constants is better than some per cent. Where no such law fits (tissue, whose compression
// is the stiffer), Ogden's stable laws are taken. The band is what these laws differ by, the
// constants' covariance and the laws' own error, together at 95 %.
class Predictor {
 public:
  // Throws std::runtime_error as FitLaw.
  explicit Predictor(const std::vector<MaterialTest>& tests);

  [[nodiscard]] PredictedRow At(const MaterialTest& test, std::size_t row) const;
  // Tests of the other kinds as far as the invariants of the fitted ones reach.
  [[nodiscard]] std::vector<PredictedCurve> OtherTests() const;
  // In words, with how well they fit.
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
