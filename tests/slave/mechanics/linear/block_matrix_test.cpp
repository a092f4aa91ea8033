// Products, on the stiffness of springs between the nodes of a cubic grid.
#include "slave/mechanics/linear/block_matrix.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/mechanics/linear/springs.h"

namespace palpate::fem {
namespace {

NodeVector Load(std::size_t nodes) {
  NodeVector r(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      r[i].v[c] = std::sin(0.7 * static_cast<double>(i) + 2.1 * static_cast<double>(c));
    }
  }
  return r;
}

// Reference: one product at a time; both sum up to 27 products of each kind in another order.
TEST(BlockMatrixTest, FourProductsAndSingleRowsAreThoseOfOneProduct) {
  const Springs springs(9, 0.1);
  const std::size_t nodes = springs.points.size();
  std::vector<NodeVector> x(4, Load(nodes)), y(4, NodeVector(nodes + 1)), one(4, y[0]);
  for (std::size_t n = 1; n < 4; ++n) {
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t c = 0; c < 3; ++c) x[n][i].v[c] = x[n - 1][(i + 1) % nodes].v[c];
    }
  }
  for (auto& of : y) of.back().v[0] = 1;  // beyond the rows: becomes zero
  springs.matrix.Multiply({&x[0], &x[1], &x[2], &x[3]}, {&y[0], &y[1], &y[2], &y[3]});
  for (std::size_t n = 0; n < 4; ++n) {
    springs.matrix.Multiply(x[n], one[n]);
    for (std::size_t i = 0; i < nodes; ++i) {
      const NodeValue row = springs.matrix.Row(static_cast<int>(i), x[n]);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(y[n][i].v[c], one[n][i].v[c], 1e-13) << "vector " << n << ", node " << i;
        ASSERT_NEAR(row.v[c], one[n][i].v[c], 1e-13) << "vector " << n << ", node " << i;
      }
    }
    EXPECT_EQ(y[n].back().v[0], 0);
  }
}

}  // namespace
}  // namespace palpate::fem
