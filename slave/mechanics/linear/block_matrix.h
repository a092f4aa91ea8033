// Vectors with three components per node, their operations for iterative solvers, and symmetric
// sparse matrices of 3 x 3 blocks with one row per moving node.
#pragma once

#include <array>
#include <span>
#include <vector>

namespace palpate::fem {

// x, y, z of a node and a zero, so that nodes are aligned and whole vectors can be multiplied.
struct alignas(32) NodeValue {
  double v[4] = {0, 0, 0, 0};
};
// Nodes in the solver's order.
using NodeVector = std::vector<NodeValue>;

// The sum over all nodes of a . b; the same bits on every call.
double Dot(const NodeVector& a, const NodeVector& b) noexcept;
double Norm(const NodeVector& a) noexcept;
// The largest component's size; NaN if there is one.
double LargestComponent(const NodeVector& a) noexcept;
// y += alpha x
void Add(double alpha, const NodeVector& x, NodeVector& y) noexcept;
// y = x + beta y
void ScaleAndAdd(double beta, const NodeVector& x, NodeVector& y) noexcept;
// x = alpha x
void Scale(double alpha, NodeVector& x) noexcept;
void SetZero(NodeVector& x) noexcept;

inline NodeValue& At(NodeVector& x, int node) {
  return x[static_cast<std::size_t>(node)];
}
inline const NodeValue& At(const NodeVector& x, int node) {
  return x[static_cast<std::size_t>(node)];
}

// Neighbours of nodes through elements: those of node i are column[begin[i]] to column[begin[i + 1]
// - 1].
struct NodeGraph {
  std::vector<int> begin, column;
  [[nodiscard]] int size() const { return static_cast<int>(begin.size()) - 1; }
  [[nodiscard]] std::span<const int> of(int i) const {
    const auto first = static_cast<std::size_t>(begin[static_cast<std::size_t>(i)]);
    const auto last = static_cast<std::size_t>(begin[static_cast<std::size_t>(i) + 1]);
    return {column.data() + first, last - first};
  }
};

// Positions of the blocks: row by row, columns rising, both triangles.
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

// Stores a reference to its pattern.
class BlockMatrix {
 public:
  explicit BlockMatrix(const BlockPattern& pattern);

  // Nine numbers, column by column; one block more than the pattern has may be written.
  [[nodiscard]] double* block(int k) { return values_.data() + 9 * static_cast<std::size_t>(k); }
  [[nodiscard]] const double* block(int k) const {
    return values_.data() + 9 * static_cast<std::size_t>(k);
  }
  [[nodiscard]] const BlockPattern& pattern() const { return *pattern_; }
  [[nodiscard]] std::size_t memory_bytes() const { return values_.size() * sizeof(double); }

  // y = A x on the moving nodes; zero on those after them.
  void Multiply(const NodeVector& x, NodeVector& y) const noexcept;
  // Multiplies four vectors in little more time than one, because most of it is for reading A.
  void Multiply(const std::array<const NodeVector*, 4>& x,
                const std::array<NodeVector*, 4>& y) const noexcept;
  // A row of A x.
  [[nodiscard]] NodeValue Row(int row, const NodeVector& x) const noexcept;

 private:
  const BlockPattern* pattern_;
  std::vector<double> values_;
};

// y = S x, S the matrix of one number per block times the identity; zero beyond its rows.
void MultiplyScalars(const BlockPattern& pattern, const std::vector<double>& scalars,
                     const NodeVector& x, NodeVector& y) noexcept;

}  // namespace palpate::fem
