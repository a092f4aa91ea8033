#include "slave/mechanics/linear/elimination_order.h"

#include <array>
#include <mutex>
#include <new>

#include <metis.h>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

// METIS uses rand(), whose state is common to the process. With priority inheritance, a background
// thread gets the priority of the sensing thread that waits for it.
PriorityInheritanceMutex the_random_numbers;

// Orders by METIS; order[new] = old.
std::vector<int> Dissected(const std::vector<std::vector<int>>& neighbours) {
  std::vector<idx_t> begin{0}, others;
  for (int i = 0; i < static_cast<int>(neighbours.size()); ++i) {
    for (const int j : neighbours[Index(i)]) {
      if (j != i) others.push_back(j);
    }
    begin.push_back(static_cast<idx_t>(others.size()));
  }
  auto nodes = static_cast<idx_t>(neighbours.size());
  std::vector<idx_t> order(neighbours.size()), rank(neighbours.size());
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  const std::lock_guard lock(the_random_numbers);
  if (METIS_NodeND(&nodes, begin.data(), others.data(), nullptr, options.data(), order.data(),
                   rank.data()) != METIS_OK) {
    throw std::bad_alloc();
  }
  return {order.begin(), order.end()};
}

// Returns for each position in the order that of its parent in the elimination tree (Liu 1990); -1:
// a root.
std::vector<int> ParentsOf(const std::vector<std::vector<int>>& neighbours,
                           const std::vector<int>& order) {
  std::vector<int> rank(order.size()), parent(order.size(), -1), root(order.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) rank[Index(order[i])] = static_cast<int>(i);
  for (int i = 0; i < static_cast<int>(order.size()); ++i) {
    for (const int other : neighbours[Index(order[Index(i)])]) {
      for (int k = rank[Index(other)]; k >= 0 && k < i;) {
        const int above = root[Index(k)];
        root[Index(k)] = i;  // shortens later searches (path compression)
        if (above < 0) parent[Index(k)] = i;
        k = above;
      }
    }
  }
  return parent;
}

}  // namespace

std::vector<int> EliminationOrder(const std::vector<std::vector<int>>& neighbours) {
  if (neighbours.empty()) return {};
  const std::vector<int> order = Dissected(neighbours);
  const std::vector<int> parent = ParentsOf(neighbours, order);
  // Numbers in reverse order: every node, then the trees of its children, the last child first.
  std::vector<std::vector<int>> children(order.size());
  std::vector<int> waiting, sorted;
  for (int i = 0; i < static_cast<int>(order.size()); ++i) {
    (parent[Index(i)] < 0 ? waiting : children[Index(parent[Index(i)])]).push_back(i);
  }
  while (!waiting.empty()) {
    const int node = waiting.back();
    waiting.pop_back();
    sorted.push_back(order[Index(node)]);
    waiting.insert(waiting.end(), children[Index(node)].begin(), children[Index(node)].end());
  }
  return {sorted.rbegin(), sorted.rend()};
}

}  // namespace palpate
