// Products, on the stiffness of springs between the nodes of a cubic grid.
#include "slave/mechanics/linear/block_matrix.h"

#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace palpate::fem {
namespace {

using Eigen::Vector3d;

NodeGraph GraphOf(const std::vector<Vector3d>& points) {
  NodeGraph graph{{0}, {}};
  for (const auto& p : points) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      if ((points[j] - p).lpNorm<Eigen::Infinity>() <= 1) {
        graph.column.push_back(static_cast<int>(j));
      }
    }
    graph.begin.push_back(static_cast<int>(graph.column.size()));
  }
  return graph;
}

std::vector<Vector3d> Points() {
  std::vector<Vector3d> points;
  for (int i = 0; i < 729; ++i) points.emplace_back(i % 9, i / 9 % 9, i / 81);
  return points;
}

// Springs of stiffness one, and an anchor of every node as stiff as 0.1.
struct Cube {
  BlockPattern pattern = MakePattern(GraphOf(Points()));
  BlockMatrix matrix{pattern};

  Cube() {
    const std::vector<Vector3d> points = Points();
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::Matrix3d sum = 0.1 * Eigen::Matrix3d::Identity();
      int k = pattern.graph.begin[i];
      for (const int j : pattern.graph.of(static_cast<int>(i))) {
        const Vector3d edge = points[static_cast<std::size_t>(j)] - points[i];
        Eigen::Map<Eigen::Matrix3d> block(matrix.block(k++));
        block.setZero();
        if (edge.isZero(0)) continue;
        block = -edge * edge.transpose() / edge.squaredNorm();
        sum -= block;
      }
      Eigen::Map<Eigen::Matrix3d>(matrix.block(pattern.diagonal[i])) = sum;
    }
  }
};

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
  const Cube cube;
  const std::size_t nodes = Points().size();
  std::vector<NodeVector> x(4, Load(nodes)), y(4, NodeVector(nodes + 1)), one(4, y[0]);
  for (std::size_t n = 1; n < 4; ++n) {
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t c = 0; c < 3; ++c) x[n][i].v[c] = x[n - 1][(i + 1) % nodes].v[c];
    }
  }
  for (auto& of : y) of.back().v[0] = 1;  // beyond the rows: becomes zero
  cube.matrix.Multiply({&x[0], &x[1], &x[2], &x[3]}, {&y[0], &y[1], &y[2], &y[3]});
  for (std::size_t n = 0; n < 4; ++n) {
    cube.matrix.Multiply(x[n], one[n]);
    for (std::size_t i = 0; i < nodes; ++i) {
      const NodeValue row = cube.matrix.Row(static_cast<int>(i), x[n]);
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
