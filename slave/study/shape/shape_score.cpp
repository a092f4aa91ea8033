#include "slave/study/shape/shape_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/octree/octree_search.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "slave/contact/surface_contact.h"

namespace palpate::study {

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

// Converts `points` relative to `origin`.
Cloud::Ptr ToPcl(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& origin) {
  auto cloud = std::make_shared<Cloud>();
  for (const auto& p : points) cloud->emplace_back().getVector3fMap() = (p - origin).cast<float>();
  return cloud;
}

// Returns the score of one octree that has a leaf corner at `corner`.
double ShareInLeaves(std::span<const Eigen::Vector3d> measured,
                     std::span<const Eigen::Vector3d> simulated, double leaf,
                     const Eigen::Vector3d& corner) {
  double reach = leaf;  // half of the octree's edge: leaf times a power of two
  for (const auto& p : measured) {
    while (reach <= (p - corner).lpNorm<Eigen::Infinity>()) reach *= 2;
  }
  pcl::octree::OctreePointCloudSearch<pcl::PointXYZ> octree(leaf);
  octree.defineBoundingBox(-reach, -reach, -reach, reach, reach, reach);
  octree.setInputCloud(ToPcl(measured, corner));
  octree.addPointsFromInputCloud();
  const auto inside = std::ranges::count_if(
      *ToPcl(simulated, corner), [&](const auto& p) { return octree.isVoxelOccupiedAtPoint(p); });
  return static_cast<double>(inside) / static_cast<double>(simulated.size());
}

}  // namespace

double OctreeScore(std::span<const Eigen::Vector3d> measured,
                   std::span<const Eigen::Vector3d> simulated, double leaf) {
  if (measured.empty() || simulated.empty()) return std::numeric_limits<double>::quiet_NaN();
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const auto& p : measured) centroid += p / static_cast<double>(measured.size());
  double sum = 0;
  for (unsigned k = 0; k < 8; ++k) {
    const auto side = [&](unsigned bit) { return (k & bit) != 0 ? 0.25 : -0.25; };
    const Eigen::Vector3d corner = centroid + leaf * Eigen::Vector3d(side(1), side(2), side(4));
    sum += ShareInLeaves(measured, simulated, leaf, corner);
  }
  return sum / 8;
}

DistanceSummary Summarised(std::vector<double> distances) {
  if (distances.empty()) return {};
  const auto n = static_cast<double>(distances.size());
  double sum = 0, squares = 0;
  for (const double d : distances) sum += d, squares += d * d;
  std::ranges::sort(distances);
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * n)) - 1;
  return {sum / n, std::sqrt(squares / n), distances[rank], distances.back()};
}

std::vector<double> DistancesToSurface(std::span<const Eigen::Vector3d> points,
                                       const SurfaceMesh& surface) {
  std::vector<double> distances;
  if (surface.triangles.empty()) return distances;
  const SurfaceContact places(surface);
  for (const auto& p : points) {
    if (const auto place = places.Find(p, std::numeric_limits<double>::max())) {
      distances.push_back(place->distance);
    }
  }
  return distances;
}

std::vector<double> DistancesToCloud(std::span<const Eigen::Vector3d> points,
                                     std::span<const Eigen::Vector3d> cloud) {
  std::vector<double> distances;
  if (cloud.empty()) return distances;
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setInputCloud(ToPcl(cloud, cloud.front()));
  const Cloud::Ptr asked = ToPcl(points, cloud.front());
  pcl::Indices nearest;
  std::vector<float> squared;
  for (const auto& p : *asked) {
    tree.nearestKSearch(p, 1, nearest, squared);
    distances.push_back(std::sqrt(static_cast<double>(squared[0])));
  }
  return distances;
}

ShapeScore Score(std::span<const Eigen::Vector3d> measured,
                 std::span<const Eigen::Vector3d> simulated, const SurfaceMesh& estimate,
                 double leaf) {
  return {OctreeScore(measured, simulated, leaf), measured.size(), simulated.size(),
          Summarised(DistancesToSurface(measured, estimate)),
          Summarised(DistancesToCloud(simulated, measured))};
}

}  // namespace palpate::study
