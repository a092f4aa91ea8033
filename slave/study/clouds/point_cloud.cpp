#include "slave/study/clouds/point_cloud.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <unordered_map>

#include <Eigen/Eigenvalues>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace palpate::study {
namespace {

constexpr int kBits = 21;  // of an axis
constexpr double kHalf = 1 << (kBits - 1);
constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;

pcl::PointXYZ ToPcl(const Eigen::Vector3d& p) {
  const Eigen::Vector3f q = p.cast<float>();
  return {q.x(), q.y(), q.z()};
}

// The direction in which the neighbours spread least, towards the pupil.
Eigen::Vector3d Normal(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& p) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d n = solver.eigenvectors().col(0);
  return n.dot(p) > 0 ? Eigen::Vector3d(-n) : n;
}

}  // namespace

Eigen::Vector3d CentroidOf(std::span<const Eigen::Vector3d> points) noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const auto& p : points) {
    if (p.allFinite()) sum += p, count += 1;
  }
  return sum / std::max(1.0, count);
}

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

struct PointTree::Tree {
  pcl::KdTreeFLANN<pcl::PointXYZ> flann{false};  // results unsorted
};

PointTree::PointTree(std::span<const Eigen::Vector3d> points) : tree_(std::make_unique<Tree>()) {
  auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(points.size());
  for (const auto& p : points) {
    if (!p.allFinite()) throw std::invalid_argument("a point that is not finite: accepted is none");
    cloud->push_back(ToPcl(p));
  }
  if (cloud->empty()) throw std::invalid_argument("no points: accepted is one or more");
  tree_->flann.setInputCloud(cloud);
}

PointTree::~PointTree() = default;

PointTree::Neighbour PointTree::Nearest(const Eigen::Vector3d& p) const {
  pcl::Indices indices(1);
  std::vector<float> squared(1);
  tree_->flann.nearestKSearch(ToPcl(p), 1, indices, squared);
  return {static_cast<std::size_t>(indices[0]), std::sqrt(static_cast<double>(squared[0]))};
}

double PointTree::NextTo(const Eigen::Vector3d& p) const {
  constexpr int kEnough = 4;  // a few may lie in the same place
  pcl::Indices indices(kEnough);
  std::vector<float> squared(kEnough);
  const int found = tree_->flann.nearestKSearch(ToPcl(p), kEnough, indices, squared);
  for (int i = 0; i < found; ++i) {
    const float d2 = squared[static_cast<std::size_t>(i)];
    if (d2 > 0) return std::sqrt(static_cast<double>(d2));
  }
  return 0;
}

void PointTree::Within(const Eigen::Vector3d& p, double radius,
                       std::vector<std::size_t>* indices) const {
  pcl::Indices found;
  std::vector<float> squared;
  tree_->flann.radiusSearch(ToPcl(p), radius, found, squared);
  indices->assign(found.begin(), found.end());
}

std::vector<NeighbourhoodShape> NeighbourhoodShapes(std::span<const Eigen::Vector3d> points,
                                                    const PointTree& tree, double radius) {
  std::vector<NeighbourhoodShape> around(points.size());
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], radius, &near);
    const auto n = static_cast<double>(near.size());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (const std::size_t j : near) {
      const Eigen::Vector3d d = (points[j] - points[i]) / radius;
      sum += d;
      squares += d * d.transpose();
    }
    around[i].neighbours = near.size();
    if (near.size() < 3) continue;
    const Eigen::Vector3d centroid = sum / n;
    const Eigen::Vector3d normal = Normal(squares / n - centroid * centroid.transpose(), points[i]);
    around[i].before = centroid.dot(normal);
    around[i].beside = (centroid - around[i].before * normal).norm();
  }
  return around;
}

}  // namespace palpate::study
