#include "slave/study/clouds/segmentation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <boost/pending/disjoint_sets.hpp>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing_rgb.h>

#include "shared/statistics/robust.h"
#include "slave/study/clouds/point_cloud.h"
#include "slave/study/clouds/support_plane.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

// Shares of a voxel's edge and of the neighbourhood's radius, for 3 mm: 12 mm, 6 mm, 6 mm. On the
// labelled cloud of cylindrical objects every label keeps the same region for voxels of 3 and 4 mm,
// neighbourhoods of 10 to 15 mm, borders from 0.20 to 0.25 and links of 6 to 8 mm.
constexpr double kRadius = 4, kLink = 2, kTolerance = 2;
constexpr double kBorder = 0.25;
constexpr double kGroove = 0.10;         // folded by about 27 degrees
constexpr double kShallowGroove = 0.06;  // by 16 degrees
constexpr double kOtherColour = 40;      // of 442
constexpr std::size_t kFewest = 6;       // neighbours that make a surface

PointCloud Selected(const PointCloud& cloud, const std::vector<std::size_t>& indices) {
  PointCloud selected;
  for (const std::size_t i : indices) {
    selected.points.push_back(cloud.points[i]);
    if (!cloud.colours.empty()) selected.colours.push_back(cloud.colours[i]);
  }
  return selected;
}

// Median distance of a point to the one next to it [m].
double Spacing(const PointCloud& cloud) {
  const PointTree tree(cloud.points);
  std::vector<double> distances;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / 1000);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    distances.push_back(tree.NextTo(cloud.points[i]));
  }
  return MedianOf(distances);
}

Vector3d Colour(const PointCloud& cloud, std::size_t i) {
  const auto& [r, g, b] = cloud.colours[i];
  return {static_cast<double>(r), static_cast<double>(g), static_cast<double>(b)};
}

// Where patches of one colour each touch.
struct Border {
  double before = 0;  // sum over the links
  double links = 0;
};

// Step 3: the surface each core voxel belongs to, as the number of one of its voxels.
std::vector<std::size_t> GrowSurfaces(const PointCloud& core, const std::vector<double>& before,
                                      double link, const ColourGrowth& colour) {
  const std::vector<int> patch_of = GrowColours(core, colour);
  const int patches = patch_of.empty() ? 0 : *std::ranges::max_element(patch_of) + 1;
  std::vector<Vector3d> mean(static_cast<std::size_t>(patches), Vector3d::Zero());
  std::vector<double> count(mean.size(), 0);
  const auto patch = [&](std::size_t i) { return static_cast<std::size_t>(patch_of[i]); };
  for (std::size_t i = 0; i < core.size() && !core.colours.empty(); ++i) {
    if (patch_of[i] < 0) continue;
    count[patch(i)] += 1;
    mean[patch(i)] += Colour(core, i);
  }
  for (std::size_t k = 0; k < mean.size(); ++k) mean[k] /= std::max(1.0, count[k]);

  boost::disjoint_sets_with_storage<> surfaces(core.size());
  std::map<std::pair<int, int>, Border> borders;
  std::vector<std::pair<std::size_t, std::size_t>> across;
  const PointTree tree(core.points);
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < core.size(); ++i) {
    if (patch_of[i] < 0) continue;
    tree.Within(core.points[i], link, &near);
    for (const std::size_t j : near) {
      if (j <= i || patch_of[j] < 0) continue;
      if (patch_of[i] == patch_of[j]) {
        surfaces.union_set(i, j);
        continue;
      }
      Border& border = borders[std::minmax(patch_of[i], patch_of[j])];
      border.before += 0.5 * (before[i] + before[j]);
      border.links += 1;
      across.emplace_back(i, j);
    }
  }
  for (const auto& [i, j] : across) {
    const Border& border = borders[std::minmax(patch_of[i], patch_of[j])];
    const bool other_colour = (mean[patch(i)] - mean[patch(j)]).norm() > kOtherColour;
    // A few links round the end of a groove are no border.
    const double fewest = 2 * std::sqrt(std::min(count[patch(i)], count[patch(j)]));
    const bool smooth = border.links >= fewest && border.before <= kShallowGroove * border.links;
    if (!other_colour || smooth) surfaces.union_set(i, j);
  }
  std::vector<std::size_t> surface_of(core.size());
  for (std::size_t i = 0; i < core.size(); ++i) surface_of[i] = surfaces.find_set(i);
  return surface_of;
}

// Those with enough neighbours to lie on a surface; the others are strays.
std::vector<std::size_t> WithoutStrays(const PointCloud& cloud, double radius) {
  std::vector<std::size_t> kept, near;
  const PointTree tree(cloud.points);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    tree.Within(cloud.points[i], radius, &near);
    if (near.size() >= kFewest) kept.push_back(i);
  }
  return kept;
}

// Steps 1 to 4 on voxels.
struct Surfaces {
  std::vector<long> region_of;  // a name per voxel, -1 for none
  std::vector<bool> in_support;
};

Surfaces SurfacesOf(const VoxelCloud& voxels, double edge, const SegmentationOptions& options) {
  SupportPlaneOptions plane;
  plane.tolerance = kTolerance * edge;
  plane.extent = options.plane;
  const std::vector<std::size_t> sound = WithoutStrays(voxels.cloud, kRadius * edge);
  const std::vector<bool> supports = InSupportPlanes(Selected(voxels.cloud, sound).points, plane);
  Surfaces surfaces{std::vector<long>(voxels.cloud.size(), -1),
                    std::vector<bool>(voxels.cloud.size(), false)};
  auto& region_of = surfaces.region_of;
  std::vector<std::size_t> standing;
  for (std::size_t i = 0; i < sound.size(); ++i) {
    surfaces.in_support[sound[i]] = supports[i];
    if (!supports[i]) standing.push_back(sound[i]);
  }
  if (standing.empty()) return surfaces;

  const PointCloud rest = Selected(voxels.cloud, standing);
  const std::vector<NeighbourhoodShape> around =
      NeighbourhoodShapes(rest.points, PointTree(rest.points), kRadius * edge);
  std::vector<std::size_t> core;  // of `rest`
  std::vector<double> before;
  for (std::size_t i = 0; i < around.size(); ++i) {
    if (around[i].neighbours < kFewest || around[i].beside > kBorder ||
        around[i].before > kGroove) {
      continue;
    }
    core.push_back(i);
    before.push_back(around[i].before);
  }
  if (core.empty()) return surfaces;

  const PointCloud grown = Selected(rest, core);
  std::vector<std::size_t> surface_of = GrowSurfaces(grown, before, kLink * edge, options.colour);
  std::map<std::size_t, std::size_t> points_of;
  for (std::size_t k = 0; k < core.size(); ++k) {
    points_of[surface_of[k]] += voxels.points_in[standing[core[k]]];
  }
  std::vector<std::size_t> kept;  // of `grown`
  for (std::size_t k = 0; k < core.size(); ++k) {
    if (points_of[surface_of[k]] >= options.smallest) kept.push_back(k);
  }
  if (kept.empty()) return surfaces;
  const PointTree tree(Selected(grown, kept).points);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const auto [nearest, distance] = tree.Nearest(rest.points[i]);
    if (distance > 2 * kRadius * edge) continue;
    region_of[standing[i]] = static_cast<long>(surface_of[kept[nearest]]);
  }
  return surfaces;
}

// Names become numbers, the largest region first; small ones are dropped.
Segmentation Numbered(const VoxelCloud& voxels, const std::vector<long>& name_of,
                      std::size_t smallest) {
  std::map<long, std::size_t> points_of;
  for (std::size_t i = 0; i < name_of.size(); ++i) {
    if (name_of[i] >= 0) points_of[name_of[i]] += voxels.points_in[i];
  }
  std::vector<std::pair<std::size_t, long>> order;
  for (const auto& [name, points] : points_of) {
    if (points >= smallest) order.emplace_back(points, name);
  }
  std::ranges::sort(order, std::greater<>());
  std::map<long, int> number;
  Segmentation segmentation;
  for (const auto& [points, name] : order) {
    number[name] = static_cast<int>(segmentation.size.size());
    segmentation.size.push_back(points);
  }
  for (const std::size_t voxel : voxels.voxel_of) {
    const auto found = number.find(name_of[voxel]);
    segmentation.region_of.push_back(found == number.end() ? -1 : found->second);
  }
  return segmentation;
}

}  // namespace

std::vector<int> GrowColours(const PointCloud& cloud, const ColourGrowth& options) {
  if (cloud.colours.empty() || cloud.size() == 0) return std::vector<int>(cloud.size(), 0);
  using Point = pcl::PointXYZRGB;
  auto input = std::make_shared<pcl::PointCloud<Point>>();
  input->reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.points[i].cast<float>();
    const auto& [r, g, b] = cloud.colours[i];
    input->push_back(Point(p.x(), p.y(), p.z(), r, g, b));
  }
  pcl::RegionGrowingRGB<Point> growing;
  growing.setInputCloud(input);
  growing.setSearchMethod(std::make_shared<pcl::search::KdTree<Point>>());
  growing.setNumberOfNeighbours(static_cast<unsigned>(options.neighbours));
  growing.setPointColorThreshold(static_cast<float>(options.point_colour));
  growing.setRegionColorThreshold(static_cast<float>(options.region_colour));
  growing.setDistanceThreshold(static_cast<float>(options.distance));
  growing.setMinClusterSize(options.smallest);
  std::vector<pcl::PointIndices> regions;
  growing.extract(regions);

  std::vector<int> region_of(cloud.size(), -1);
  for (std::size_t k = 0; k < regions.size(); ++k) {
    for (const auto i : regions[k].indices) {
      region_of[static_cast<std::size_t>(i)] = static_cast<int>(k);
    }
  }
  return region_of;
}

Segmentation Segment(const PointCloud& cloud, const SegmentationOptions& options) {
  if (cloud.size() == 0) return {};
  const double edge = options.voxel > 0 ? options.voxel : std::max(0.003, 1.5 * Spacing(cloud));
  const VoxelCloud voxels = Voxelised(cloud, edge);
  Surfaces surfaces;
  if (options.method == SegmentationOptions::Method::kColour) {
    const std::vector<int> region_of = GrowColours(voxels.cloud, options.colour);
    surfaces.region_of.assign(region_of.begin(), region_of.end());
  } else {
    surfaces = SurfacesOf(voxels, edge, options);
  }
  Segmentation segmentation = Numbered(voxels, surfaces.region_of, options.smallest);
  segmentation.voxel = edge;
  if (surfaces.in_support.empty()) return segmentation;
  for (const std::size_t voxel : voxels.voxel_of) {
    segmentation.in_support.push_back(surfaces.in_support[voxel]);
  }
  return segmentation;
}

}  // namespace palpate::study
