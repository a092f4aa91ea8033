#include "slave/mechanics/linear/dense_factor.h"

#include <algorithm>
#include <limits>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::MatrixXd;

// X of A X = B; empty where the solver refuses.
MatrixXd Solve(DenseFactor& factor, const MatrixXd& A, const MatrixXd& B) {
  const int order = static_cast<int>(A.rows());
  factor.Reset(order);
  for (int i = 0; i < order; ++i) {
    for (int j = 0; j < order; ++j) factor.row(i)[j] = A(i, j);
  }
  if (!factor.Factorise()) return {};
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows x = Rows::Zero(order, PaddedTo8(static_cast<int>(B.cols())));
  x.leftCols(B.cols()) = B;
  factor.Solve({x.data(), static_cast<int>(x.cols())});
  return x.leftCols(B.cols());
}

// Reference: the residual; a backward stable elimination has a residual of some epsilon times the
// order. Orders decrease as well as increase, so that remains of a larger matrix would show.
TEST(DenseFactor, LeavesNoResidualAtAnyOrderAndNumberOfRightHandSides) {
  std::srand(7);
  DenseFactor factor;
  for (const int order : {31, 1, 2, 3, 4, 5, 300, 7, 8, 9, 15, 16, 32, 33, 64, 129}) {
    for (const int columns : {1, 2, 5, 8, 20}) {
      const MatrixXd A = MatrixXd::Random(order, order);
      const MatrixXd B = MatrixXd::Random(order, columns);
      const MatrixXd X = Solve(factor, A, B);
      ASSERT_EQ(X.rows(), order);
      EXPECT_LT((A * X - B).norm(), 1e-13 * order * A.norm() * X.norm()) << order << 'x' << columns;
    }
  }
}

// A zero on the diagonal is no zero pivot: rows are swapped across panels, before and after others.
TEST(DenseFactor, SwapsRowsWhereTheDiagonalVanishes) {
  const int order = 21;
  MatrixXd A = MatrixXd::Zero(order, order);
  for (int i = 0; i < order; ++i) A(i, (i + 10) % order) = 1 + i;
  A.row(3) += 0.5 * A.row(17);
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(order, 1, 2);
  DenseFactor factor;
  const MatrixXd X = Solve(factor, A, A * x);
  ASSERT_EQ(X.rows(), order);
  EXPECT_LT((X - x).norm(), 1e-13);
}

TEST(DenseFactor, RefusesSingularAndInfiniteSystems) {
  DenseFactor factor;
  MatrixXd A = MatrixXd::Random(12, 12);
  A.col(7) = A.col(3) - 2 * A.col(11);
  EXPECT_EQ(Solve(factor, A, MatrixXd::Ones(12, 1)).size(), 0);
  EXPECT_EQ(Solve(factor, MatrixXd::Zero(3, 3), MatrixXd::Ones(3, 1)).size(), 0);
  A.setIdentity();
  for (const double bad :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    A(5, 5) = bad;
    EXPECT_EQ(Solve(factor, A, MatrixXd::Ones(12, 1)).size(), 0);
  }
  A(5, 5) = 1;  // this value must not remain
  EXPECT_EQ(Solve(factor, A, MatrixXd::Ones(12, 1)), MatrixXd::Ones(12, 1));
}

}  // namespace
}  // namespace palpate
