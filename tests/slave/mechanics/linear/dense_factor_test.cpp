#include "slave/mechanics/linear/dense_factor.h"

#include <limits>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Positive definite, with a skew part if not symmetric.
RowMajorMatrix Made(int order, bool symmetric) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> side(-1, 1);
  const auto R = MatrixXd::NullaryExpr(order, order + 5, [&] { return side(random); }).eval();
  MatrixXd A = R * R.transpose() / order + 0.05 * MatrixXd::Identity(order, order);
  const auto S = MatrixXd::NullaryExpr(order, order, [&] { return side(random); }).eval();
  if (!symmetric) A += 0.2 * (S - S.transpose()) / std::sqrt(order);
  return A;
}

class DenseFactorTest : public testing::TestWithParam<bool> {};

// Reference: Eigen's pivoted LU. Condition numbers are below 1e3: 1e-12 leaves a digit. Orders go
// down as well as up: nothing of a larger matrix stays.
TEST_P(DenseFactorTest, SolvesAndInvertsEveryOrder) {
  DenseFactor factor;
  for (int step = 1; step <= 70; ++step) {
    const int n = step % 2 == 0 ? 71 - step : step;
    const RowMajorMatrix A = Made(n, GetParam());
    ASSERT_TRUE(factor.Factorise(A.data(), n, n, GetParam(), 1e-11));
    VectorXd b = VectorXd::Zero(factor.size()), x(factor.size());
    b.head(n) = VectorXd::LinSpaced(n, -1, 2);
    factor.Solve(b.data(), x.data());
    const MatrixXd P = A.inverse();
    const VectorXd expected = P * b.head(n);
    EXPECT_LT((x.head(n) - expected).norm(), 1e-12 * expected.norm()) << n;
    EXPECT_TRUE(x.tail(factor.size() - n).isZero(0)) << n;
    factor.InvertTriangles();
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        ASSERT_NEAR(factor.InverseEntry(i, j), P(i, j), 1e-12 * P.cwiseAbs().maxCoeff())
            << n << ": " << i << ", " << j;
      }
    }
  }
}

TEST_P(DenseFactorTest, RefusesWhatIsSingularOrNotFinite) {
  DenseFactor factor;
  RowMajorMatrix A = Made(20, GetParam());
  A.row(13) = A.row(4);
  A.col(13) = A.col(4);
  EXPECT_FALSE(factor.Factorise(A.data(), 20, 20, GetParam(), 1e-11));
  A = Made(20, GetParam());
  A(13, 4) = A(4, 13) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(factor.Factorise(A.data(), 20, 20, GetParam(), 1e-11));
}

INSTANTIATE_TEST_SUITE_P(Symmetry, DenseFactorTest, testing::Bool(),
                         [](const auto& kind) { return kind.param ? "Symmetric" : "General"; });

}  // namespace
}  // namespace palpate
