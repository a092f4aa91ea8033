#include "slave/study/clouds/voxel_grid.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <unordered_map>

namespace palpate::study {
namespace {

constexpr int kBits = 21;  // of an axis
constexpr double kHalf = 1 << (kBits - 1);
constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;

}  // namespace

std::optional<std::uint64_t> CellOf(const Eigen::Vector3d& p, double edge) noexcept {
  std::uint64_t cell = 0;
  for (const double x : p) {
    const double k = std::floor(x / edge) + kHalf;
    if (!(k >= 0 && k < 2 * kHalf)) return std::nullopt;
    cell = (cell << kBits) | static_cast<std::uint64_t>(k);
  }
  return cell;
}

Eigen::Vector3d CornerOf(std::uint64_t cell, double edge) noexcept {
  const auto axis = [&](int place) {
    return (static_cast<double>((cell >> (place * kBits)) & kMask) - kHalf) * edge;
  };
  return {axis(2), axis(1), axis(0)};
}

VoxelCloud Voxelised(const PointCloud& cloud, double edge) {
  VoxelCloud voxels;
  std::unordered_map<std::uint64_t, std::size_t> known;
  std::vector<Eigen::Vector3d> colour_sums;
  const bool coloured = !cloud.colours.empty();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto cell = CellOf(cloud.points[i], edge);
    if (!cell) {
      throw std::invalid_argument("a point too far from the origin for voxels of " +
                                  std::to_string(edge) + " m: accepted is fewer than 2^20 voxels");
    }
    const auto [found, is_new] = known.try_emplace(*cell, voxels.points_in.size());
    if (is_new) {
      voxels.cloud.points.emplace_back(Eigen::Vector3d::Zero());
      voxels.points_in.push_back(0);
      colour_sums.emplace_back(Eigen::Vector3d::Zero());
    }
    const std::size_t voxel = found->second;
    voxels.voxel_of.push_back(voxel);
    ++voxels.points_in[voxel];
    voxels.cloud.points[voxel] += cloud.points[i];
    if (coloured) {
      const auto& [r, g, b] = cloud.colours[i];
      colour_sums[voxel] += Eigen::Vector3d(r, g, b);
    }
  }
  for (std::size_t k = 0; k < voxels.points_in.size(); ++k) {
    const auto n = static_cast<double>(voxels.points_in[k]);
    voxels.cloud.points[k] /= n;
    if (!coloured) continue;
    const Eigen::Vector3d mean = colour_sums[k] / n;
    const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(x)); };
    voxels.cloud.colours.push_back({byte(mean.x()), byte(mean.y()), byte(mean.z())});
  }
  return voxels;
}

}  // namespace palpate::study
