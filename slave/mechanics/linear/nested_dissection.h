// The order in which the nodes of a solid are eliminated, and the tree of the separators.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace palpate::fem {

// Nodes [begin, end) of the new order, eliminated together.
struct Supernode {
  int begin = 0, end = 0;
  int parent = -1;  // has a larger index; -1: a root
};

struct EliminationTree {
  std::vector<int> order;             // of the nodes: order[new] = old
  std::vector<Supernode> supernodes;  // children before parents
};

// Which nodes share an element: those of node i are column[begin[i]] to column[begin[i + 1] - 1].
struct NodeGraph {
  std::vector<int> begin, column;
  [[nodiscard]] int size() const { return static_cast<int>(begin.size()) - 1; }
  [[nodiscard]] std::span<const int> of(int i) const {
    const auto first = static_cast<std::size_t>(begin[static_cast<std::size_t>(i)]);
    const auto last = static_cast<std::size_t>(begin[static_cast<std::size_t>(i) + 1]);
    return {column.data() + first, last - first};
  }
};

// Halves the nodes again and again across their longer extent; the nodes between two halves come
// after both. Source: George (1973), by coordinates. O(N log N).
EliminationTree Dissect(const NodeGraph& graph, std::span<const Eigen::Vector3d> points);

}  // namespace palpate::fem
