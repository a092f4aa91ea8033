// Finds points that are the same up to a tolerance.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace palpate {

class NodeMerger {
 public:
  // Points, of finite coordinates, within `tolerance` >= 0 of each other are one.
  explicit NodeMerger(double tolerance);
  // The number of the first point like `p`, which is added under the next number if there is none.
  // O(1) on average.
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

}  // namespace palpate
