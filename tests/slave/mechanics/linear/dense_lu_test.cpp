#include "slave/mechanics/linear/dense_lu.h"

#include <cmath>
#include <limits>
#include <random>
#include <thread>
#include <vector>

#include <Eigen/LU>
#include <dlfcn.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::MatrixXd;

constexpr int kBlockWidth = DenseLu::kWidth;

// Returns a matrix without a dominant diagonal, so that row swaps are needed everywhere.
MatrixXd RandomMatrix(int order) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> side(-1, 1);
  return MatrixXd::NullaryExpr(order, order, [&] { return side(random); });
}

double Norm1(const MatrixXd& m) {
  return m.cwiseAbs().colwise().sum().maxCoeff();
}

bool Factorize(DenseLu* lu) {
  while (lu->done() < lu->blocks()) {
    if (!lu->FactorizeNext()) return false;
  }
  return true;
}

MatrixXd Solved(const MatrixXd& A, MatrixXd B) {
  DenseLu lu(A);
  EXPECT_TRUE(Factorize(&lu));
  lu.SolveInPlace(B);
  return B;
}

// Reference: the residual of partial pivoting is some n eps, and Eigen's own LU; orders on both
// sides of the width of blocks. Tolerance of the second: conditions are below 1e5.
TEST(DenseLu, SolutionsLeaveNoResidual) {
  for (const int order :
       {1, 7, 100, kBlockWidth - 1, kBlockWidth, kBlockWidth + 1, 2 * kBlockWidth + 40}) {
    const MatrixXd A = RandomMatrix(order);
    const MatrixXd B = MatrixXd::Random(order, 5);
    const MatrixXd X = Solved(A, B);
    EXPECT_LT((A * X - B).norm(), 1e-15 * order * A.norm() * X.norm()) << "order " << order;
    const MatrixXd expected = A.partialPivLu().solve(B);
    EXPECT_LT((X - expected).norm(), 1e-10 * expected.norm()) << "order " << order;
  }
}

// Reference: the inverse. The estimate never exceeds the condition and is mostly within a factor
// of three; up to a condition of 1e10 the inverse has the digits for that.
TEST(DenseLu, ConditionIsThatOfTheInverse) {
  for (const int order : {5, 150, kBlockWidth + 44}) {
    for (const double smallest : {1.0, 1e-4, 1e-9}) {
      MatrixXd A = RandomMatrix(order);
      A.row(order / 2) = A.row(0) + smallest * A.row(order / 2);
      DenseLu lu(A);
      ASSERT_TRUE(Factorize(&lu));
      const double condition = Norm1(A) * Norm1(A.inverse());
      EXPECT_LE(1 / lu.ReciprocalCondition(), condition * 1.001) << order << ' ' << smallest;
      EXPECT_GT(1 / lu.ReciprocalCondition(), condition / 3) << order << ' ' << smallest;
    }
  }
}

TEST(DenseLu, RefusesSingularAndInfiniteSystems) {
  MatrixXd A = RandomMatrix(kBlockWidth + 50);
  A.col(kBlockWidth + 10).setZero();
  DenseLu lu(A);
  EXPECT_TRUE(lu.FactorizeNext());
  EXPECT_FALSE(lu.FactorizeNext());
  DenseLu zero(MatrixXd::Zero(3, 3));
  EXPECT_FALSE(zero.FactorizeNext());
  const int order = kBlockWidth + 50;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const int row : {0, 100, order - 1}) {
      for (const int column : {0, 100, order - 1}) {
        MatrixXd spoilt = RandomMatrix(order);
        spoilt(row, column) = bad;
        DenseLu refused(spoilt);
        EXPECT_FALSE(Factorize(&refused)) << bad << " at " << row << ", " << column;
      }
    }
  }
}

// Models are made on separate threads. Reference: one thread, bit for bit.
TEST(DenseLu, ThreadsDoNotDisturbEachOther) {
  const MatrixXd A = RandomMatrix(kBlockWidth + 100);
  const MatrixXd B = MatrixXd::Identity(A.rows(), A.cols());
  const MatrixXd expected = Solved(A, B);
  std::vector<MatrixXd> solved(4);
  {
    std::vector<std::jthread> threads;
    for (auto& x : solved) {
      threads.emplace_back([&] {
        for (int k = 0; k < 5; ++k) x = Solved(A, B);
      });
    }
  }
  for (const auto& x : solved) EXPECT_EQ(x, expected);
}

// Reference: OpenBLAS's own description; another BLAS has no such function.
TEST(DenseLu, BlasLocksItsBuffersAndStartsNoThreads) {
  const auto is_threaded =
      reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
  const auto threads = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  if (is_threaded == nullptr || threads == nullptr) GTEST_SKIP() << "not OpenBLAS";
  EXPECT_NE(is_threaded(), 0) << "built without threads, it has no locks";
  EXPECT_EQ(threads(), 1);
}

}  // namespace
}  // namespace palpate
