#include "slave/mechanics/linear/sparse_ldlt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "slave/mechanics/linear/elimination_order.h"
#include "slave/mechanics/linear/spd_factor.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

// Returns the neighbours of each node on a grid of side^3 nodes, including diagonal ones.
std::vector<std::vector<int>> Grid(int side) {
  std::vector<std::vector<int>> neighbours;
  const auto number = [&](int x, int y, int z) { return x + side * (y + side * z); };
  for (int i = 0; i < side * side * side; ++i) {
    auto& list = neighbours.emplace_back();
    const int x = i % side, y = i / side % side, z = i / side / side;
    for (int c = std::max(z - 1, 0); c <= std::min(z + 1, side - 1); ++c) {
      for (int b = std::max(y - 1, 0); b <= std::min(y + 1, side - 1); ++b) {
        for (int a = std::max(x - 1, 0); a <= std::min(x + 1, side - 1); ++a) {
          list.push_back(number(a, b, c));
        }
      }
    }
  }
  return neighbours;
}

// Symmetric with random entries between neighbours, upper triangle, nodes renumbered by `order`.
// `negative`: how many of the nodes have a negative diagonal. Diagonals dominate: the inertia is
// that of the diagonal (Sylvester's law and Gershgorin's circles).
Sparse Matrix(const std::vector<std::vector<int>>& neighbours, const std::vector<int>& order,
              int negative) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> side(-1, 1);
  std::vector<int> rank(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    rank[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < static_cast<int>(order.size()); ++i) {
    for (const int j : neighbours[static_cast<std::size_t>(i)]) {
      if (j > i) continue;
      const int a = rank[static_cast<std::size_t>(i)], b = rank[static_cast<std::size_t>(j)];
      const double value = i != j ? side(random) : i < negative ? -30 : 30;
      entries.emplace_back(std::min(a, b), std::max(a, b), value);
    }
  }
  const auto n = static_cast<Eigen::Index>(order.size());
  Sparse matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

template <typename Count>
std::vector<int> AsNumbered(Count nodes) {
  std::vector<int> order(static_cast<std::size_t>(nodes));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

MatrixXd Full(const Sparse& upper) {
  const MatrixXd half = upper;
  return half.selfadjointView<Eigen::Upper>();
}

TEST(EliminationOrder, IsThatOfAllNodesAndTheSameAgain) {
  for (const int side : {1, 2, 5, 9}) {
    const auto order = EliminationOrder(Grid(side));
    EXPECT_TRUE(std::ranges::is_permutation(order, AsNumbered(order.size()))) << side;
    EXPECT_EQ(static_cast<int>(order.size()), side * side * side);
    EXPECT_EQ(EliminationOrder(Grid(side)), order);
  }
  EXPECT_EQ(EliminationOrder({{0}, {1}, {2}}).size(), 3U);  // no unknowns are coupled
}

// Reference: in the order of numbering, slice by slice, a factor has side^5 entries. With nested
// dissection it has about 31 n log2 n on a plane grid, and about 10 side^4 on this one.
TEST(EliminationOrder, KeepsFactorsSparse) {
  const auto grid = Grid(14);
  const auto entries = [&](const std::vector<int>& order) {
    return SparseLdlt<double>(Matrix(grid, order, 0)).entries();
  };
  EXPECT_LT(entries(EliminationOrder(grid)), entries(AsNumbered(grid.size())) * 6 / 10);
}

template <typename Scalar>
class SparseLdltTest : public testing::Test {
 protected:
  using Columns = typename SparseLdlt<Scalar>::Columns;
  using Vector = typename SparseLdlt<Scalar>::Vector;

  static constexpr double kTolerance = 500 * std::numeric_limits<Scalar>::epsilon();

  static SparseLdlt<Scalar> Allocated(const Sparse& matrix) {
    SparseLdlt<Scalar> factor(matrix);
    factor.Allocate(matrix);
    return factor;
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SparseLdltTest, Scalars);

// Reference: Eigen's dense LU, one right-hand side alone and among several. Tolerance: conditions
// are below a hundred.
TYPED_TEST(SparseLdltTest, SolvesWhatIsDefiniteAndWhatIsNot) {
  for (const int side : {1, 2, 4, 8}) {
    for (const int negative : {0, side * side}) {
      const auto grid = Grid(side);
      const Sparse matrix = Matrix(grid, EliminationOrder(grid), negative);
      auto factor = this->Allocated(matrix);
      ASSERT_TRUE(factor.Factorize(matrix, negative == 0));
      EXPECT_EQ(factor.negative_pivots(), negative);
      EXPECT_EQ(factor.Factorize(matrix, true), negative == 0);
      ASSERT_TRUE(factor.Factorize(matrix, false));  // the refused matrix has no effect
      const VectorXd b = VectorXd::LinSpaced(matrix.cols(), -1, 2);
      typename TestFixture::Vector x = b.cast<TypeParam>();
      typename TestFixture::Columns several = x.replicate(1, 3);
      factor.Solve(&x);
      factor.Solve(several);
      const VectorXd expected = Full(matrix).partialPivLu().solve(b);
      for (const typename TestFixture::Vector& is :
           {x, typename TestFixture::Vector(several.col(2))}) {
        EXPECT_LT((is.template cast<double>() - expected).norm(),
                  this->kTolerance * expected.norm())
            << side << ", " << negative;
      }
    }
  }
}

// Reference: the same factor made in one call, equal to the last bit. No part may take a large
// fraction of the work.
TYPED_TEST(SparseLdltTest, AFactorMadeInPartsIsTheSame) {
  using Progress = typename SparseLdlt<TypeParam>::Progress;
  constexpr int kParts = 8;
  const auto grid = Grid(18);
  const Sparse matrix = Matrix(grid, EliminationOrder(grid), 0);
  auto at_once = this->Allocated(matrix), in_parts = this->Allocated(matrix);
  ASSERT_TRUE(at_once.Factorize(matrix, true));
  const long before = AllocationCount();
  for (int repeat = 0; repeat < 2; ++repeat) {  // the first one is given up
    in_parts.Begin(matrix, true);
    int parts = 1;
    while (in_parts.Continue(in_parts.flops() / kParts) == Progress::kMore) {
      ++parts;
      if (repeat == 0 && parts == 3) break;
    }
    if (repeat == 1) EXPECT_GE(parts, kParts - 2);
  }
  typename TestFixture::Vector one = TestFixture::Vector::LinSpaced(matrix.cols(), -1, 2);
  typename TestFixture::Vector other = one;
  at_once.Solve(&one);
  in_parts.Solve(&other);
  EXPECT_EQ(AllocationCount(), before);
  EXPECT_EQ(one, other);
}

TYPED_TEST(SparseLdltTest, RefusesZeroPivotsAndWhatIsNotFinite) {
  const auto grid = Grid(4);
  Sparse matrix = Matrix(grid, EliminationOrder(grid), 0);
  auto factor = this->Allocated(matrix);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Sparse spoilt = matrix;
    spoilt.coeffRef(20, 20) = bad;
    EXPECT_FALSE(factor.Factorize(spoilt, false)) << bad;
  }
  Sparse zero = matrix;
  zero *= 0.0;
  EXPECT_FALSE(factor.Factorize(zero, false));
  EXPECT_TRUE(factor.Factorize(matrix, true));
}

// The rows need not be in the order of elimination.
TEST(SpdFactor, SolvesSeveralAtOnceAndRefusesTheIndefinite) {
  const auto grid = Grid(6);
  const Sparse matrix = Matrix(grid, AsNumbered(grid.size()), 0);
  SpdFactor factor(matrix.transpose());
  const MatrixXd B = MatrixXd::Random(matrix.cols(), 3);
  MatrixXd X = B;
  factor.Solve(X.data(), 3);
  EXPECT_LT((Full(matrix) * X - B).norm(), 1e-13 * B.norm());
  EXPECT_THROW(SpdFactor(Matrix(grid, AsNumbered(grid.size()), 1).transpose()),
               std::invalid_argument);
}

}  // namespace
}  // namespace palpate
