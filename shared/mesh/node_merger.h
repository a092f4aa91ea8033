// Finds points that coincide within a tolerance.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace palpate {

class NodeMerger {
 public:
  // Finite points within `tolerance` >= 0 of each other count as one.
  explicit NodeMerger(double tolerance);
  // Number of the first point that coincides with `p`; adds `p` if there is none. O(1) on average.
  int FindOrAdd(const Eigen::Vector3d& p);

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Cell& cell) const noexcept;
  };
  [[nodiscard]] Cell CellOf(const Eigen::Vector3d& p) const;
  [[nodiscard]] int Find(const Eigen::Vector3d& p) const;

  double tolerance_, edge_;
  std::vector<Eigen::Vector3d> points_;
  std::unordered_map<Cell, std::vector<int>, Hash> cells_;
};

// Midpoints of edges as new nodes, each once, for refinement and ten-node elements.
class EdgeMiddles {
 public:
  // New nodes are appended to `nodes`, which must outlive this.
  explicit EdgeMiddles(std::vector<Eigen::Vector3d>* nodes) : nodes_(*nodes) {}

  // Number of the midpoint node of `a` and `b`, in either order; it is created if needed.
  int operator()(int a, int b) {
    const auto low = static_cast<std::uint64_t>(std::min(a, b));
    const auto high = static_cast<std::uint64_t>(std::max(a, b));
    const auto [found, is_new] =
        numbers_.try_emplace(high << 32U | low, static_cast<int>(nodes_.size()));
    if (is_new) {
      const Eigen::Vector3d middle =
          0.5 * (nodes_[static_cast<std::size_t>(a)] + nodes_[static_cast<std::size_t>(b)]);
      nodes_.push_back(middle);
    }
    return found->second;
  }

 private:
  std::vector<Eigen::Vector3d>& nodes_;
  std::unordered_map<std::uint64_t, int> numbers_;
};

}  // namespace palpate
