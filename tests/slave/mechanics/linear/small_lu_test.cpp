#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "slave/mechanics/linear/dense_factor.h"

namespace palpate {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// X of A X = B; empty where the solver refuses.
Eigen::MatrixXd Solve(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  const int order = static_cast<int>(A.rows());
  const int first = PaddedTo8(order);
  const int stride = first + PaddedTo8(static_cast<int>(B.cols()));
  RowMatrix augmented = RowMatrix::Zero(order, stride);
  augmented.leftCols(order) = A;
  augmented.middleCols(first, B.cols()) = B;
  std::vector<double> scratch(static_cast<std::size_t>(kPanel * order));
  if (!SolveInPlace({augmented.data(), stride}, order, scratch.data())) return {};
  return augmented.middleCols(first, B.cols());
}

// Reference: the residual, backward stable elimination leaves some epsilon times order.
TEST(SmallLu, LeavesNoResidualAtAnyOrderAndNumberOfRightHandSides) {
  std::srand(7);
  for (const int order : {1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 31, 32, 33, 64, 129, 300}) {
    for (const int columns : {1, 2, 5, 8}) {
      const Eigen::MatrixXd A = Eigen::MatrixXd::Random(order, order);
      const Eigen::MatrixXd B = Eigen::MatrixXd::Random(order, columns);
      const Eigen::MatrixXd X = Solve(A, B);
      ASSERT_EQ(X.rows(), order);
      EXPECT_LT((A * X - B).norm(), 1e-13 * order * A.norm() * X.norm()) << order << 'x' << columns;
    }
  }
}

// Unit vectors on the right, whose zeros are skipped: the inverse, also where rows are swapped.
TEST(SmallLu, InvertsWithUnitVectorsOnTheRight) {
  std::srand(11);
  for (const int order : {3, 8, 20, 32, 45, 129}) {
    const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(order, order);
    for (const double diagonal : {0.0, 10.0}) {
      const Eigen::MatrixXd A = Eigen::MatrixXd::Random(order, order) + diagonal * I;
      const Eigen::MatrixXd X = Solve(A, I);
      ASSERT_EQ(X.rows(), order);
      EXPECT_LT((A * X - I).norm(), 1e-13 * order * A.norm() * X.norm()) << order;
    }
  }
}

// A zero on the diagonal is no zero pivot: rows are swapped across panels.
TEST(SmallLu, SwapsRowsWhereTheDiagonalVanishes) {
  const int order = 21;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(order, order);
  for (int i = 0; i < order; ++i) A(i, (i + 10) % order) = 1 + i;
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(order, 1, 2);
  const Eigen::MatrixXd X = Solve(A, A * x);
  ASSERT_EQ(X.rows(), order);
  EXPECT_LT((X - x).norm(), 1e-14);
}

TEST(SmallLu, RefusesSingularAndInfiniteSystems) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Random(12, 12);
  A.col(7) = A.col(3) - 2 * A.col(11);
  EXPECT_EQ(Solve(A, Eigen::MatrixXd::Ones(12, 1)).size(), 0);
  EXPECT_EQ(Solve(Eigen::MatrixXd::Zero(3, 3), Eigen::MatrixXd::Ones(3, 1)).size(), 0);
  A.setIdentity();
  A(5, 5) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Solve(A, Eigen::MatrixXd::Ones(12, 1)).size(), 0);
  A(5, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Solve(A, Eigen::MatrixXd::Ones(12, 1)).size(), 0);
}

}  // namespace
}  // namespace palpate
