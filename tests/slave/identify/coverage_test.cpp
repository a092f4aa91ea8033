// Tests that intervals of 95 % contain 95 of 100 true values.
#include <cmath>

#include <gtest/gtest.h>

#include "slave/identify/law_fit.h"
#include "tests/slave/identify/synthetic.h"

namespace palpate::identify {
namespace {

// 200 draws of noise: 95 % within 5 points is three standard deviations of the count.
TEST(Coverage, OfTheConstantsIsAsStated) {
  const HyperLaw truth{.name = "", .terms = {{3e4, 1.6}, {4e3, -3}}};
  const double G = truth.ShearModulus();
  int covered = 0;
  constexpr int kDraws = 200;
  for (unsigned draw = 0; draw < kDraws; ++draw) {
    const std::vector<MaterialTest> tests{
        CurveOf(truth, TestKind::kUniaxial, 2, 60, 0.01, 2 * draw + 1),
        CurveOf(truth, TestKind::kEquibiaxial, 1.6, 60, 0.01, 2 * draw + 2)};
    const LawFit fit = FitLaw(Family("ogden-2"), tests);
    const Eigen::Vector4d sum(1, 1, 0, 0);
    const double sigma = std::sqrt(sum.dot(fit.covariance * sum));
    covered += std::abs(fit.law.ShearModulus() - G) < 1.96 * sigma;
  }
  EXPECT_NEAR(covered / static_cast<double>(kDraws), 0.95, 0.05);
}

}  // namespace
}  // namespace palpate::identify
