// In which order an array is found in a picture: from three neighbours outwards.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// The next dot is expected at sum weight place(parent), which is exact under affine maps; parents
// come before it in the order, the nearest first.
struct GrowthStep {
  static constexpr std::size_t kMostParents = 8;
  int dot = 0;
  int parents = 0;
  std::array<int, kMostParents> parent{};
  std::array<double, kMostParents> weight{};
};
using Growth = std::vector<GrowthStep>;  // the first three, not on one line, have no parents

// Places are finite and differ. Throws std::invalid_argument: all nearly on one line.
Growth GrowthFrom(const std::vector<Eigen::Vector2d>& layout, std::size_t anchor);
// The dot in the middle, then up to `most` in all, far from each other.
std::vector<std::size_t> SpreadAnchors(const std::vector<Eigen::Vector2d>& layout,
                                       std::size_t most);
// Of each dot, up to `most` others, nearest first.
std::vector<std::vector<int>> NearestNeighbours(const std::vector<Eigen::Vector2d>& layout,
                                                std::size_t most);

}  // namespace palpate
