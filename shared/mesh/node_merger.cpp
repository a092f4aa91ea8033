#include "shared/mesh/node_merger.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

constexpr double kEdge = 64;  // edge of a cell in tolerances, so that few points are near two cells

}  // namespace

NodeMerger::NodeMerger(double tolerance) : tolerance_(tolerance), edge_(kEdge * tolerance) {}

std::size_t NodeMerger::Hash::operator()(const Cell& cell) const noexcept {
  std::uint64_t hash = 0;
  for (const std::int64_t i : cell) {
    hash = (hash ^ static_cast<std::uint64_t>(i)) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 32U;
  }
  return hash;
}

// Without a tolerance every position is a separate cell (0 and -0 are equal).
NodeMerger::Cell NodeMerger::CellOf(const Eigen::Vector3d& p) const {
  constexpr double kMaxCell = 9e18;  // largest number of a cell
  constexpr double kMaxCoordinate = std::numeric_limits<double>::max();
  Cell cell{};
  for (int i = 0; i < 3; ++i) {
    const double x = std::clamp(p[i], -kMaxCoordinate, kMaxCoordinate);  // a reach may overflow
    cell[static_cast<std::size_t>(i)] =
        tolerance_ > 0
            ? static_cast<std::int64_t>(std::clamp(std::floor(x / edge_), -kMaxCell, kMaxCell))
            : std::bit_cast<std::int64_t>(x == 0 ? 0.0 : x);
  }
  return cell;
}

// Searches the cells that the tolerance ball around `p` intersects.
int NodeMerger::Find(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(tolerance_);
  const Cell low = CellOf(p - reach), high = CellOf(p + reach);
  int first = std::numeric_limits<int>::max();
  for (std::int64_t i = low[0]; i <= high[0]; ++i) {
    for (std::int64_t j = low[1]; j <= high[1]; ++j) {
      for (std::int64_t k = low[2]; k <= high[2]; ++k) {
        const auto found = cells_.find({i, j, k});
        if (found == cells_.end()) continue;
        for (const int n : found->second) {
          const bool same = (points_[static_cast<std::size_t>(n)] - p).norm() <= tolerance_;
          if (same && n < first) first = n;
        }
      }
    }
  }
  return first;
}

int NodeMerger::FindOrAdd(const Eigen::Vector3d& p) {
  const int found = Find(p);
  const int next = static_cast<int>(points_.size());
  if (found < next) return found;
  points_.push_back(p);
  cells_[CellOf(p)].push_back(next);
  return next;
}

}  // namespace palpate
