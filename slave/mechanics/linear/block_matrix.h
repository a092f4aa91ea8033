// A symmetric sparse matrix of 3 x 3 blocks, one row per moving node.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "slave/mechanics/linear/nested_dissection.h"
#include "slave/mechanics/linear/node_vector.h"

namespace palpate::fem {

// Where the blocks are: row by row, columns rising, both halves.
struct BlockPattern {
  NodeGraph graph;             // rows and columns, the diagonal included
  std::vector<int> diagonal;   // per row: its block
  std::vector<int> transpose;  // per block: the one mirrored at the diagonal

  [[nodiscard]] int rows() const { return graph.size(); }
  [[nodiscard]] int blocks() const { return static_cast<int>(graph.column.size()); }
  // The block at (row, column); -1: none.
  [[nodiscard]] int Find(int row, int column) const;
};

// Completes the transposes of a graph that includes the diagonal.
BlockPattern MakePattern(NodeGraph graph);

// Keeps a reference to its pattern.
class BlockMatrix {
 public:
  explicit BlockMatrix(const BlockPattern& pattern);

  // Nine numbers, column by column.
  [[nodiscard]] double* block(int k) { return values_.data() + 9 * static_cast<std::size_t>(k); }
  [[nodiscard]] const double* block(int k) const {
    return values_.data() + 9 * static_cast<std::size_t>(k);
  }
  [[nodiscard]] const BlockPattern& pattern() const { return *pattern_; }
  [[nodiscard]] std::size_t memory_bytes() const { return values_.size() * sizeof(double); }

  // y = A x on the moving nodes; zero on those after them.
  void Multiply(const NodeVector& x, NodeVector& y) const noexcept;

 private:
  const BlockPattern* pattern_;
  std::vector<double> values_;
};

// y = S x, S the matrix of one number per block times the identity; zero beyond its rows.
void MultiplyScalars(const BlockPattern& pattern, const std::vector<double>& scalars,
                     const NodeVector& x, NodeVector& y) noexcept;

}  // namespace palpate::fem
