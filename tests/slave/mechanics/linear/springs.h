// The stiffness of springs on a cubic grid, for tests of products and preconditioners.
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/block_matrix.h"

namespace palpate::fem {

// Springs of stiffness one between all neighbours of a cubic grid, those along diagonals included,
// and an anchor of every node as stiff as `anchor`.
struct Springs {
  std::vector<Eigen::Vector3d> points;
  BlockPattern pattern;
  BlockMatrix matrix;
  NodeVector free;

  Springs(int side, double anchor)
      : points(Grid(side)), pattern(PatternOf(points)), matrix(pattern), free(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      // The bottom is fixed, and one side cannot move across.
      const bool bottom = points[i].z() == 0;
      for (std::size_t c = 0; c < 3; ++c) {
        free[i].v[c] = bottom || (c == 0 && points[i].x() == 0) ? 0 : 1;
      }
      Eigen::Matrix3d sum = anchor * Eigen::Matrix3d::Identity();
      int k = pattern.graph.begin[i];
      for (const int j : pattern.graph.of(static_cast<int>(i))) {
        const Eigen::Vector3d edge = points[static_cast<std::size_t>(j)] - points[i];
        Eigen::Map<Eigen::Matrix3d> block(matrix.block(k++));
        block.setZero();
        if (edge.isZero(0)) continue;
        block = -edge * edge.transpose() / edge.squaredNorm();
        sum -= block;
      }
      Eigen::Map<Eigen::Matrix3d>(matrix.block(pattern.diagonal[i])) = sum;
    }
  }

  static std::vector<Eigen::Vector3d> Grid(int side) {
    std::vector<Eigen::Vector3d> points;
    for (int z = 0; z < side; ++z) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) points.emplace_back(x, y, z);
      }
    }
    return points;
  }
  static BlockPattern PatternOf(const std::vector<Eigen::Vector3d>& points) {
    NodeGraph graph{{0}, {}};
    for (const auto& p : points) {
      for (std::size_t j = 0; j < points.size(); ++j) {
        if ((points[j] - p).lpNorm<Eigen::Infinity>() <= 1) {
          graph.column.push_back(static_cast<int>(j));
        }
      }
      graph.begin.push_back(static_cast<int>(graph.column.size()));
    }
    return MakePattern(std::move(graph));
  }
};

}  // namespace palpate::fem
