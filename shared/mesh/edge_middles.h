// Middles of edges as new nodes, each once: what refinement and ten-node elements share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace palpate {

class EdgeMiddles {
 public:
  // New nodes are appended to `nodes`, which must outlive this.
  explicit EdgeMiddles(std::vector<Eigen::Vector3d>* nodes) : nodes_(*nodes) {}

  // Number of the node half way between nodes `a` and `b`, in either order; made where there is
  // none yet.
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
