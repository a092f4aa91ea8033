#include "slave/study/clouds/segmentation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include <Eigen/Eigenvalues>
#include <boost/pending/disjoint_sets.hpp>
#include <pcl/common/centroid.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/octree/octree_search.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing_rgb.h>

#include "slave/statistics/robust.h"
#include "slave/study/clouds/support_plane.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;
using Point = PointCloud::PointType;
using Tree = pcl::KdTreeFLANN<Point>;

// Shares of a voxel's edge and of the neighbourhood's radius, for 3 mm: 12 mm, 6 mm, 6 mm. On the
// labelled cloud of cylindrical objects every label keeps the same region for voxels of 3 and 4 mm,
// neighbourhoods of 10 to 15 mm, borders from 0.20 to 0.25 and links of 6 to 8 mm.
constexpr double kRadius = 4, kLink = 2, kTolerance = 2;
constexpr double kBorder = 0.25;
constexpr double kGroove = 0.10;           // corresponds to a fold of about 27 degrees
constexpr double kShallowGroove = 0.06;    // corresponds to an angle of 16 degrees
constexpr double kOtherColour = 40;        // colour distance, of at most 442
constexpr std::size_t kMinNeighbours = 6;  // neighbours that make a surface
constexpr std::size_t kMinPoints = 150;    // points of a region

struct Voxels {
  PointCloud::Ptr cloud = std::make_shared<PointCloud>();  // mean positions and colours
  std::vector<pcl::Indices> points;                        // of each voxel
};

Voxels Voxelised(const PointCloud::ConstPtr& cloud, double edge) {
  pcl::octree::OctreePointCloudSearch<Point> octree(edge);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  Voxels voxels;
  for (auto leaf = octree.leaf_depth_begin(); leaf != octree.leaf_depth_end(); ++leaf) {
    voxels.points.push_back(leaf.getLeafContainer().getPointIndicesVector());
    pcl::CentroidPoint<Point> mean;
    for (const auto i : voxels.points.back()) mean.add((*cloud)[i]);
    mean.get(voxels.cloud->emplace_back());
  }
  return voxels;
}

// Returns the median distance of a point to the nearest one at another position [m].
double Spacing(const PointCloud::ConstPtr& cloud) {
  constexpr int kEnough = 4;  // a few points may be at the same position
  Tree tree;
  tree.setInputCloud(cloud);
  std::vector<float> distances, squared;
  pcl::Indices near;
  const std::size_t step = std::max<std::size_t>(1, cloud->size() / 1000);
  for (std::size_t i = 0; i < cloud->size(); i += step) {
    tree.nearestKSearch((*cloud)[i], kEnough, near, squared);
    const auto elsewhere = std::ranges::find_if(squared, [](float d2) { return d2 > 0; });
    distances.push_back(elsewhere == squared.end() ? 0 : std::sqrt(*elsewhere));
  }
  return MedianOf(distances);
}

// Offset of the neighbours' centroid, relative to the radius.
struct Neighbourhood {
  double beside = 0;  // tangential, 0 to 1, 0.42 on a straight edge where the surface ends
  double before = 0;  // along the normal, which points to the camera, -1 to 1, 0.30 in a
                      // right-angled groove, negative on ridges
};

Neighbourhood Compared(const PointCloud& cloud, const Point& point, const pcl::Indices& near,
                       double radius) {
  Eigen::Matrix3d covariance;
  Eigen::Vector4d centroid;
  pcl::computeMeanAndCovarianceMatrix(cloud, near, covariance, centroid);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Vector3d p = point.getVector3fMap().cast<double>();
  Vector3d normal = solver.eigenvectors().col(0);
  if (normal.dot(p) > 0) normal = -normal;
  const Vector3d offset = (centroid.head<3>() - p) / radius;
  const double before = offset.dot(normal);
  return {(offset - before * normal).norm(), before};
}

// Returns the region of every point, from 0; -1: none.
std::vector<int> GrowColours(const PointCloud::ConstPtr& cloud) {
  pcl::RegionGrowingRGB<Point> growing;
  growing.setInputCloud(cloud);
  growing.setSearchMethod(std::make_shared<pcl::search::KdTree<Point>>());
  growing.setNumberOfNeighbours(30);
  growing.setPointColorThreshold(20);   // of at most 442, between neighbours in a region
  growing.setRegionColorThreshold(10);  // neighbouring regions with a smaller difference are merged
  growing.setDistanceThreshold(0.01F);  // between regions that are neighbours [m]
  growing.setMinClusterSize(30);        // smaller clusters are merged with a neighbour or dropped
  std::vector<pcl::PointIndices> regions;
  growing.extract(regions);
  std::vector<int> region_of(cloud->size(), -1);
  for (std::size_t k = 0; k < regions.size(); ++k) {
    for (const auto i : regions[k].indices) {
      region_of[static_cast<std::size_t>(i)] = static_cast<int>(k);
    }
  }
  return region_of;
}

struct Patch {
  Vector3d colour = Vector3d::Zero();
  double voxels = 0;
};

std::vector<Patch> Patches(const PointCloud& core, const std::vector<int>& patch_of) {
  std::vector<Patch> patches(static_cast<std::size_t>(1 + *std::ranges::max_element(patch_of)));
  for (std::size_t i = 0; i < core.size(); ++i) {
    if (patch_of[i] < 0) continue;
    Patch& patch = patches[static_cast<std::size_t>(patch_of[i])];
    patch.voxels += 1;
    patch.colour += core[i].getRGBVector3i().cast<double>();
  }
  for (Patch& patch : patches) patch.colour /= patch.voxels;
  return patches;
}

// The border of two patches.
struct Border {
  std::vector<std::pair<std::size_t, std::size_t>> links;  // voxels of one and of the other
  double before = 0;                                       // sum over the links
};

// Returns whether the patches on the border's sides are one surface.
bool IsInside(const Border& border, const Patch& one, const Patch& other) {
  if ((one.colour - other.colour).norm() <= kOtherColour) return true;
  const auto links = static_cast<double>(border.links.size());
  // A few links around the end of a groove do not make a common border.
  return links >= 2 * std::sqrt(std::min(one.voxels, other.voxels)) &&
         border.before <= kShallowGroove * links;
}

// Step 3: returns for each core voxel its surface, identified by the index of one of the surface's
// voxels.
std::vector<int> GrowSurfaces(const PointCloud::ConstPtr& core, const std::vector<double>& before,
                              double link) {
  const std::vector<int> patch_of = GrowColours(core);
  boost::disjoint_sets_with_storage<> surfaces(core->size());
  std::map<std::pair<int, int>, Border> borders;
  Tree tree;
  tree.setInputCloud(core);
  pcl::Indices near;
  std::vector<float> squared;
  for (std::size_t i = 0; i < core->size(); ++i) {
    tree.radiusSearch((*core)[i], link, near, squared);
    for (const auto neighbour : near) {
      const auto j = static_cast<std::size_t>(neighbour);
      if (j <= i || patch_of[i] < 0 || patch_of[j] < 0) continue;
      if (patch_of[i] == patch_of[j]) {
        surfaces.union_set(i, j);
      } else {
        Border& border = borders[std::minmax(patch_of[i], patch_of[j])];
        border.links.emplace_back(i, j);
        border.before += 0.5 * (before[i] + before[j]);
      }
    }
  }
  const std::vector<Patch> patches = Patches(*core, patch_of);
  for (const auto& [pair, border] : borders) {
    const auto& one = patches[static_cast<std::size_t>(pair.first)];
    if (!IsInside(border, one, patches[static_cast<std::size_t>(pair.second)])) continue;
    for (const auto& [i, j] : border.links) surfaces.union_set(i, j);
  }
  std::vector<int> surface_of;
  for (std::size_t i = 0; i < core->size(); ++i) {
    surface_of.push_back(static_cast<int>(surfaces.find_set(i)));
  }
  return surface_of;
}

// Step 1: returns the voxels that are neither outliers nor in supporting planes.
pcl::Indices Standing(const PointCloud::ConstPtr& voxels, double edge) {
  pcl::Indices standing, near;
  std::vector<float> squared;
  Tree tree;
  tree.setInputCloud(voxels);
  for (std::size_t i = 0; i < voxels->size(); ++i) {
    tree.radiusSearch((*voxels)[i], kRadius * edge, near, squared);
    if (near.size() >= kMinNeighbours) standing.push_back(static_cast<int>(i));
  }
  TakeSupportPlanes(voxels, kTolerance * edge, &standing);
  return standing;
}

// Voxels in the interior of a surface.
struct Core {
  pcl::Indices voxels;
  std::vector<double> before;  // see Neighbourhood
};

// Step 2: finds the core voxels.
Core CoreOf(const PointCloud::ConstPtr& voxels, const pcl::IndicesConstPtr& standing,
            double radius) {
  Core core;
  Tree tree;
  tree.setInputCloud(voxels, standing);
  pcl::Indices near;
  std::vector<float> squared;
  for (const auto i : *standing) {
    const Point& point = (*voxels)[static_cast<std::size_t>(i)];
    tree.radiusSearch(point, radius, near, squared);
    if (near.size() < kMinNeighbours) continue;
    const Neighbourhood around = Compared(*voxels, point, near, radius);
    if (around.beside > kBorder || around.before > kGroove) continue;
    core.voxels.push_back(i);
    core.before.push_back(around.before);
  }
  return core;
}

std::vector<std::size_t> PointsIn(const Voxels& voxels, const std::vector<int>& region_of) {
  std::vector<std::size_t> points(voxels.points.size(), 0);
  for (std::size_t i = 0; i < region_of.size(); ++i) {
    if (region_of[i] >= 0)
      points[static_cast<std::size_t>(region_of[i])] += voxels.points[i].size();
  }
  return points;
}

// Steps 1 to 4: returns the region of every voxel; -1: none.
std::vector<int> GrowRegions(const Voxels& voxels, double edge) {
  std::vector<int> region_of(voxels.cloud->size(), -1);
  const auto standing = std::make_shared<pcl::Indices>(Standing(voxels.cloud, edge));
  if (standing->empty()) return region_of;
  const Core core = CoreOf(voxels.cloud, standing, kRadius * edge);
  if (core.voxels.empty()) return region_of;
  const auto grown = std::make_shared<PointCloud>(*voxels.cloud, core.voxels);
  const std::vector<int> surface_of = GrowSurfaces(grown, core.before, kLink * edge);
  for (std::size_t k = 0; k < core.voxels.size(); ++k) {
    region_of[static_cast<std::size_t>(core.voxels[k])] = surface_of[k];
  }
  const std::vector<std::size_t> points = PointsIn(voxels, region_of);
  const auto large = [&](auto i) {
    return points[static_cast<std::size_t>(region_of[static_cast<std::size_t>(i)])] >= kMinPoints;
  };
  const auto kept = std::make_shared<pcl::Indices>();
  std::ranges::copy_if(core.voxels, std::back_inserter(*kept), large);
  std::vector<int> joined(region_of.size(), -1);
  if (kept->empty()) return joined;
  Tree tree;
  tree.setInputCloud(voxels.cloud, kept);
  pcl::Indices near;
  std::vector<float> squared;
  for (const auto i : *standing) {
    tree.nearestKSearch((*voxels.cloud)[static_cast<std::size_t>(i)], 1, near, squared);
    if (std::sqrt(squared[0]) > 2 * kRadius * edge) continue;
    joined[static_cast<std::size_t>(i)] = region_of[static_cast<std::size_t>(near[0])];
  }
  return joined;
}

// Regions by size, the largest first.
Segmentation Numbered(const Voxels& voxels, const std::vector<int>& region_of, std::size_t points) {
  const std::vector<std::size_t> points_in = PointsIn(voxels, region_of);
  std::vector<std::pair<std::size_t, std::size_t>> order;
  for (std::size_t region = 0; region < points_in.size(); ++region) {
    if (points_in[region] >= kMinPoints) order.emplace_back(points_in[region], region);
  }
  std::ranges::sort(order, std::greater<>());
  Segmentation segmentation{std::vector<int>(points, -1), {}};
  std::vector<int> number(points_in.size(), -1);
  for (const auto& [size, region] : order) {
    number[region] = static_cast<int>(segmentation.size.size());
    segmentation.size.push_back(size);
  }
  for (std::size_t i = 0; i < region_of.size(); ++i) {
    if (region_of[i] < 0) continue;
    for (const auto point : voxels.points[i]) {
      segmentation.region_of[static_cast<std::size_t>(point)] =
          number[static_cast<std::size_t>(region_of[i])];
    }
  }
  return segmentation;
}

}  // namespace

Segmentation Segment(const PointCloud::ConstPtr& cloud, Segmenting method) {
  const std::size_t points = cloud->size();
  if (method == Segmenting::kNone) return {std::vector<int>(points, 0), {points}};
  const double edge = std::max(0.003, 1.5 * Spacing(cloud));
  const Voxels voxels = Voxelised(cloud, edge);
  Segmentation segmentation = Numbered(
      voxels, method == Segmenting::kColour ? GrowColours(voxels.cloud) : GrowRegions(voxels, edge),
      points);
  segmentation.voxel = edge;
  return segmentation;
}

}  // namespace palpate::study
