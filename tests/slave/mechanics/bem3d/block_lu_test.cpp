#include "slave/mechanics/bem3d/block_lu.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::MatrixXd;

// Needs row swaps everywhere: nothing favours the diagonal.
MatrixXd RandomMatrix(int order) {
  std::srand(7);  // Eigen's generator
  return MatrixXd::Random(order, order);
}

void Factorize(BlockLu* lu) {
  while (lu->done() < lu->blocks()) ASSERT_TRUE(lu->FactorizeNext());
}

// Reference: the residual of partial pivoting is some n eps; orders on both sides of the widths of
// blocks and panels.
TEST(BlockLu, SolutionsLeaveNoResidual) {
  for (const int order : {1, 7, 9, 100, 191, 192, 193, 500}) {
    const MatrixXd A = RandomMatrix(order);
    BlockLu lu(A);
    Factorize(&lu);
    const MatrixXd B = MatrixXd::Random(order, 5);
    MatrixXd X = B;
    lu.SolveInPlace(X);
    EXPECT_LT((A * X - B).norm(), 1e-15 * order * A.norm() * X.norm()) << "order " << order;
  }
}

// Reference: the inverse. Hager's estimate is a lower bound and mostly within a factor of three.
TEST(BlockLu, ConditionIsThatOfTheInverse) {
  MatrixXd A = RandomMatrix(300);
  A.col(11) *= 1e-6;
  const auto norm = [](const MatrixXd& M) { return M.cwiseAbs().colwise().sum().maxCoeff(); };
  const double condition = norm(A) * norm(A.inverse());
  BlockLu lu(A);
  Factorize(&lu);
  EXPECT_LE(lu.Condition(), condition * (1 + 1e-9));
  EXPECT_GT(lu.Condition(), condition / 3);
}

// Reference: the factorisation that was not interrupted, bit for bit.
TEST(BlockLu, TakesUpWhatAnEarlierRunLeft) {
  const MatrixXd A = RandomMatrix(500);
  BlockLu whole(A);
  BlockLu resumed(A);
  ASSERT_TRUE(whole.FactorizeNext());
  ASSERT_TRUE(resumed.AdoptNext(whole.LastBlock()));
  ASSERT_TRUE(whole.FactorizeNext());
  ASSERT_TRUE(resumed.AdoptNext(whole.LastBlock()));
  Factorize(&whole);
  Factorize(&resumed);
  MatrixXd X = MatrixXd::Identity(500, 500);
  MatrixXd Y = X;
  whole.SolveInPlace(X);
  resumed.SolveInPlace(Y);
  EXPECT_EQ(X, Y);
}

TEST(BlockLu, TakesUpNothingThatDoesNotFit) {
  BlockLu lu(RandomMatrix(200));
  ASSERT_TRUE(lu.FactorizeNext());
  auto block = lu.LastBlock();
  BlockLu other(RandomMatrix(200));
  block[3] = 200;  // a row that does not exist
  EXPECT_FALSE(other.AdoptNext(block));
  block.pop_back();
  EXPECT_FALSE(other.AdoptNext(block));
  EXPECT_EQ(other.done(), 0);
}

TEST(BlockLu, SingularMatricesHaveNoPivot) {
  MatrixXd A = RandomMatrix(250);
  A.col(200).setZero();
  BlockLu lu(A);
  EXPECT_TRUE(lu.FactorizeNext());
  EXPECT_FALSE(lu.FactorizeNext());
}

}  // namespace
}  // namespace palpate
