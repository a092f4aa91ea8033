// One vector per node, and what iterative solvers do with many of them.
#pragma once

#include <cstddef>
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
void SetZero(NodeVector& x) noexcept;

inline NodeValue& At(NodeVector& x, int node) {
  return x[static_cast<std::size_t>(node)];
}
inline const NodeValue& At(const NodeVector& x, int node) {
  return x[static_cast<std::size_t>(node)];
}

}  // namespace palpate::fem
