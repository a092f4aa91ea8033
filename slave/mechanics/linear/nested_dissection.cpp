#include "slave/mechanics/linear/nested_dissection.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "shared/geometry/index.h"

namespace palpate::fem {
namespace {

constexpr std::size_t kLeaf = 16;  // nodes that are no longer divided

class Dissection {
 public:
  Dissection(const NodeGraph& graph, std::span<const Eigen::Vector3d> points)
      : graph_(graph), points_(points), part_(points.size(), 0) {}

  EliminationTree Run() {
    std::vector<int> all(points_.size());
    std::iota(all.begin(), all.end(), 0);
    Divide(std::move(all));
    return std::move(tree_);
  }

 private:
  // Returns the supernodes that have no parent yet.
  std::vector<int> Divide(std::vector<int> nodes) {
    if (nodes.size() <= kLeaf) return Append(nodes, {});
    const std::size_t half = nodes.size() / 2;
    const int axis = LongestAxis(nodes);
    const auto nearer = [&](int a, int b) {
      const double x = points_[Index(a)][axis], y = points_[Index(b)][axis];
      return x < y || (x == y && a < b);
    };
    std::nth_element(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(half), nodes.end(),
                     nearer);
    const int upper = ++parts_;
    for (std::size_t i = half; i < nodes.size(); ++i) part_[Index(nodes[i])] = upper;
    std::vector<int> lower_half, separator;
    for (std::size_t i = 0; i < half; ++i) {
      const auto near = graph_.of(nodes[i]);
      const bool between =
          std::any_of(near.begin(), near.end(), [&](int j) { return part_[Index(j)] == upper; });
      (between ? separator : lower_half).push_back(nodes[i]);
    }
    nodes.erase(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(half));
    std::vector<int> roots = Divide(std::move(lower_half));
    const std::vector<int> others = Divide(std::move(nodes));
    roots.insert(roots.end(), others.begin(), others.end());
    return Append(separator, std::move(roots));
  }

  std::vector<int> Append(const std::vector<int>& nodes, std::vector<int> children) {
    if (nodes.empty()) return children;
    const int begin = static_cast<int>(tree_.order.size());
    const int index = static_cast<int>(tree_.supernodes.size());
    tree_.order.insert(tree_.order.end(), nodes.begin(), nodes.end());
    tree_.supernodes.push_back({begin, static_cast<int>(tree_.order.size()), -1});
    for (const int child : children) tree_.supernodes[Index(child)].parent = index;
    return {index};
  }

  [[nodiscard]] int LongestAxis(const std::vector<int>& nodes) const {
    Eigen::AlignedBox3d box;
    for (const int i : nodes) box.extend(points_[Index(i)]);
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    return axis;
  }

  const NodeGraph& graph_;
  std::span<const Eigen::Vector3d> points_;
  EliminationTree tree_;
  std::vector<int> part_;  // per node: the last upper half it was in
  int parts_ = 0;
};

}  // namespace

EliminationTree Dissect(const NodeGraph& graph, std::span<const Eigen::Vector3d> points) {
  return Dissection(graph, points).Run();
}

}  // namespace palpate::fem
