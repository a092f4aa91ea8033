// The matrix of a factor against the dense one with rows, columns and sums replaced by hand.
#include "slave/mechanics/fem/held_tangent.h"

#include <cmath>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace palpate::fem {
namespace {

using Eigen::MatrixXd;

// Four nodes in a row, of which the first and the last share no element.
struct Row {
  BlockPattern pattern =
      MakePattern({{0, 3, 7, 11, 14}, {0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 3, 1, 2, 3}});
  BlockMatrix matrix{pattern};
  MatrixXd dense = MatrixXd::Zero(12, 12);

  Row() {
    for (int i = 0; i < 4; ++i) {
      int k = pattern.graph.begin[static_cast<std::size_t>(i)];
      for (const int j : pattern.graph.of(i)) {
        Eigen::Map<Eigen::Matrix3d> block(matrix.block(k++));
        for (int r = 0; r < 3; ++r) {
          for (int c = 0; c < 3; ++c) {
            const int a = 3 * i + r, b = 3 * j + c;
            block(r, c) = dense(a, b) = a == b ? 20 + a : std::cos(a * b) + std::cos(a + b);
          }
        }
      }
    }
  }
};

TEST(HeldTangent, ReplacesWhatIsHeld) {
  Row row;
  HeldTangent tangent(row.pattern);
  HeldComponents held;
  held.free.assign(4, NodeValue{{1, 1, 1, 0}});
  tangent.Fill(row.matrix, 0.5, held);
  EXPECT_EQ(MatrixXd(tangent.upper()), MatrixXd((0.5 * row.dense).triangularView<Eigen::Upper>()));

  held.free[1].v[2] = 0;
  held.shift = 0.25;
  HeldComponents::Sum sum{{1, 2, 7}, {{{0.5, 0.25, 0}}, {{0.5, 0.75, 1}}, {{3, 3, 3}}}};
  held.sums.push_back(sum);  // node 7 has no row
  tangent.Fill(row.matrix, 0.5, held);
  MatrixXd expected = 0.5 * row.dense;
  expected.diagonal() *= 1.25;
  expected.row(5).setZero();
  expected.col(5).setZero();
  expected(5, 5) = 1;
  for (int c = 0; c < 3; ++c) {
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) {
        expected(3 + 3 * a + c, 3 + 3 * b + c) += 1e4 * sum.weight[a].v[c] * sum.weight[b].v[c];
      }
    }
  }
  EXPECT_LT((MatrixXd(tangent.upper()) - MatrixXd(expected.triangularView<Eigen::Upper>())).norm(),
            1e-14 * expected.norm());
}

}  // namespace
}  // namespace palpate::fem
