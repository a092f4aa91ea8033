// Predictions with bands, of tests that were made and of others.
#include "slave/identify/prediction.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/slave/identify/synthetic.h"

namespace palpate::identify {
namespace {

// Share of a curve's rows whose band holds the law's own stress, as the curve's test has it.
double Covered(const PredictedCurve& curve, const HyperLaw& law, double across) {
  MaterialTest test{.kind = curve.kind, .components = {{0, 0}}};
  if (curve.kind == TestKind::kShear) test.components = {{0, 1}};
  for (const PredictedRow& row : curve.rows) {
    test.rows.push_back({.abscissa = row.abscissa, .across = 1 + across * (row.abscissa - 1)});
  }
  const Eigen::VectorXd truth = Predict(law, test);
  double covered = 0;
  for (std::size_t i = 0; i < curve.rows.size(); ++i) {
    const double stress = truth[static_cast<Eigen::Index>(i)];
    covered += curve.rows[i].low <= stress && stress <= curve.rows[i].high;
  }
  return covered / static_cast<double>(curve.rows.size());
}

// A foam from its tension and compression: the other tests follow, compression included. Nine of
// ten rows of each, since the rows of a curve err together.
TEST(Prediction, CoversAFoamsOtherTests) {
  const HyperLaw foam{.name = "", .terms = {{2e4, 7}}, .nu = 0.2};
  const Predictor predictor({CurveOf(foam, TestKind::kUniaxial, 0.5, 40, 0.01, 1),
                             CurveOf(foam, TestKind::kUniaxial, 1.3, 40, 0.01, 2)},
                            true);
  const auto curves = predictor.OtherTests();
  ASSERT_EQ(curves.size(), 4U);
  for (const PredictedCurve& curve : curves) {
    EXPECT_GT(curve.rows.size(), 10U) << curve.name;
    EXPECT_GE(Covered(curve, foam, 0.5), 0.9) << curve.name;
    if (curve.kind != TestKind::kShear) {
      EXPECT_LT(curve.rows.front().abscissa, 0.7) << curve.name;
    }
  }
}

TEST(Prediction, CoversBiaxialTensionOfRubberFromUniaxialDataAlone) {
  const HyperLaw rubber{.name = "", .terms = {{3.7e5, 1.7}, {2.2e4, -1.4}}};
  const auto curves = Predictor({CurveOf(rubber, TestKind::kUniaxial, 3, 40, 0.003)}).OtherTests();
  const auto biaxial = std::ranges::find(curves, TestKind::kBiaxial, &PredictedCurve::kind);
  ASSERT_NE(biaxial, curves.end());
  EXPECT_EQ(biaxial->name, "biaxial:0.5");
  EXPECT_GT(biaxial->rows.size(), 10U);
  EXPECT_GE(Covered(*biaxial, rubber, 0.5), 0.95);
  EXPECT_LT(Covered(*biaxial, {.name = "", .terms = {{6e5, 1.7}}}, 0.5), 0.5);  // of a stiffer one
}

// The same test as tensors and as stretches reaches as far and says the same.
TEST(Prediction, OfTensorsIsThatOfTheirStretches) {
  const HyperLaw rubber{.name = "", .terms = {{3e5, 2}}};
  const MaterialTest plain = CurveOf(rubber, TestKind::kUniaxial, 2, 30, 0.003);
  MaterialTest tensor = plain;
  tensor.kind = TestKind::kTensor;
  for (TestRow& row : tensor.rows) row.F = DeformationOf(plain, row, std::nullopt);
  const Predictor from_plain({plain}), from_tensor({tensor});
  const auto other = from_plain.OtherTests(), same = from_tensor.OtherTests();
  ASSERT_EQ(same.size(), other.size() + 1);  // a tensor is of no kind, so uniaxial is predicted too
  for (std::size_t i = 0; i < other.size(); ++i) {
    ASSERT_EQ(same[i + 1].rows.size(), other[i].rows.size()) << other[i].name;
    EXPECT_NEAR(same[i + 1].rows.back().high, other[i].rows.back().high,
                1e-6 * other[i].rows.back().high);
  }
  const auto fitted = from_tensor.FittedTests();
  ASSERT_EQ(fitted.size(), 1U);
  EXPECT_EQ(fitted[0].component, "P11");
  ASSERT_EQ(fitted[0].rows.size(), plain.rows.size());
  for (std::size_t i = 0; i < plain.rows.size(); ++i) {
    const PredictedRow& row = fitted[0].rows[i];
    EXPECT_EQ(row.abscissa, plain.rows[i].abscissa);
    EXPECT_EQ(*row.measured, plain.rows[i].measured[0]);
    EXPECT_LT(row.low, *row.measured);
    EXPECT_GT(row.high, *row.measured);
  }
}

}  // namespace
}  // namespace palpate::identify
