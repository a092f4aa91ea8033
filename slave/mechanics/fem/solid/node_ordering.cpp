#include "slave/mechanics/fem/solid/node_ordering.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Graph = std::vector<std::vector<int>>;

constexpr std::size_t kLeaf = 16;  // elements that are dissected no further

std::vector<int> MinimumDegree(const Graph& neighbours) {
  const int n = static_cast<int>(neighbours.size());
  Eigen::SparseMatrix<double, Eigen::ColMajor, int> graph(n, n);
  Eigen::VectorXi counts(n);
  for (int i = 0; i < n; ++i) counts[i] = static_cast<int>(neighbours[Index(i)].size());
  graph.reserve(counts);
  for (int i = 0; i < n; ++i) {
    for (const int j : neighbours[Index(i)]) graph.insert(j, i) = 1;
  }
  graph.makeCompressed();
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(graph, order);
  return {order.indices().data(), order.indices().data() + n};
}

class Dissection {
 public:
  explicit Dissection(const ElementMesh& mesh)
      : mesh_(mesh),
        taken_(mesh.nodes.size(), false),
        side_(mesh.nodes.size(), -1),
        elements_(Index(mesh.element_count())) {
    std::iota(elements_.begin(), elements_.end(), 0);
    for (int e = 0; e < mesh.element_count(); ++e) {
      Vector3d centre = Vector3d::Zero();
      for (const int node : mesh.element(e).first(4)) centre += mesh.nodes[Index(node)] / 4;
      centres_.push_back(centre);
    }
  }

  std::vector<int> Order() {
    Split(elements_);
    for (int node = 0; node < mesh_.node_count(); ++node) Take(node);  // those of no element
    return std::move(order_);
  }

 private:
  void Take(int node) {
    if (taken_[Index(node)]) return;
    taken_[Index(node)] = true;
    order_.push_back(node);
  }

  void Split(std::span<int> elements) {
    if (elements.size() <= kLeaf) {
      for (const int e : elements) {
        for (const int node : mesh_.element(e)) Take(node);
      }
      return;
    }
    Vector3d low = centres_[Index(elements[0])], high = low;
    for (const int e : elements) {
      low = low.cwiseMin(centres_[Index(e)]);
      high = high.cwiseMax(centres_[Index(e)]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const auto half = elements.size() / 2;
    std::nth_element(
        elements.begin(), elements.begin() + static_cast<std::ptrdiff_t>(half), elements.end(),
        [&](int a, int b) { return centres_[Index(a)][axis] < centres_[Index(b)][axis]; });
    const auto left = elements.first(half), right = elements.subspan(half);
    for (const int e : left) {
      for (const int node : mesh_.element(e)) side_[Index(node)] = left.front();
    }
    std::vector<int> between;
    for (const int e : right) {
      for (const int node : mesh_.element(e)) {
        if (side_[Index(node)] != left.front() || taken_[Index(node)]) continue;
        taken_[Index(node)] = true;
        between.push_back(node);
      }
    }
    // Marks of this cut must not be taken for those of a later one.
    for (const int e : left) {
      for (const int node : mesh_.element(e)) side_[Index(node)] = -1;
    }
    Split(left);
    Split(right);
    order_.insert(order_.end(), between.begin(), between.end());
  }

  const ElementMesh& mesh_;
  std::vector<bool> taken_;
  std::vector<int> side_;
  std::vector<int> elements_;
  std::vector<Vector3d> centres_;
  std::vector<int> order_;
};

// Sum of squares of the columns of the factor, in nodes: elimination tree and counts (Liu 1990).
double Work(const Graph& neighbours, const std::vector<int>& order) {
  const std::size_t n = order.size();
  std::vector<int> rank(n), parent(n, -1), seen(n, -1), count(n, 1);
  for (std::size_t i = 0; i < n; ++i) rank[Index(order[i])] = static_cast<int>(i);
  for (std::size_t column = 0; column < n; ++column) {
    const int here = static_cast<int>(column);
    seen[column] = here;
    for (const int neighbour : neighbours[Index(order[column])]) {
      int i = rank[Index(neighbour)];
      if (i > here) continue;
      for (; seen[Index(i)] != here; i = parent[Index(i)]) {
        if (parent[Index(i)] < 0) parent[Index(i)] = here;
        ++count[Index(i)];
        seen[Index(i)] = here;
      }
    }
  }
  double work = 0;
  for (const int c : count) work += static_cast<double>(c) * c;
  return work;
}

}  // namespace

Graph NeighboursOf(const ElementMesh& mesh) {
  Graph neighbours(Index(mesh.node_count()));
  for (int node = 0; node < mesh.node_count(); ++node) neighbours[Index(node)].push_back(node);
  for (int e = 0; e < mesh.element_count(); ++e) {
    const auto nodes = mesh.element(e);
    for (const int a : nodes) {
      neighbours[Index(a)].insert(neighbours[Index(a)].end(), nodes.begin(), nodes.end());
    }
  }
  for (auto& list : neighbours) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
    list.shrink_to_fit();
  }
  return neighbours;
}

std::vector<int> EliminationOrder(const ElementMesh& mesh, const Graph& neighbours) {
  auto by_degree = MinimumDegree(neighbours);
  auto by_halves = Dissection(mesh).Order();
  return Work(neighbours, by_halves) < Work(neighbours, by_degree) ? by_halves : by_degree;
}

}  // namespace palpate
