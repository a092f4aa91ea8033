#include "slave/study/clouds/object_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

namespace palpate::study {
namespace {

using Eigen::Vector3d;

constexpr double kFar = std::numeric_limits<double>::infinity();

struct Region {
  double points = 0, inside = 0;      // number of points of the region, and of those in the box
  Vector3d place = Vector3d::Zero();  // sum of the points, frame of the box
};

std::vector<Region> Regions(const PointCloud& cloud, const Segmentation& segmentation,
                            const ObjectHint& hint) {
  std::vector<Region> regions(segmentation.size.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (segmentation.region_of[i] < 0) continue;
    Region& region = regions[static_cast<std::size_t>(segmentation.region_of[i])];
    const Vector3d p_B = hint.X_BD * cloud[i].getVector3fMap().cast<double>();
    region.points += 1;
    region.place += p_B;
    if (hint.box.contains(p_B)) region.inside += 1;
  }
  return regions;
}

// Largest distance of the selected point from `--at` [m].
constexpr double kReach = 0.05;

int NearestTo(const Vector3d& at, const PointCloud& cloud, const Segmentation& segmentation) {
  int best = 0;
  double nearest = kFar;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double d = (cloud[i].getVector3fMap().cast<double>() - at).squaredNorm();
    if (segmentation.region_of[i] >= 0 && d < nearest) {
      nearest = d, best = segmentation.region_of[i];
    }
  }
  if (!(nearest <= kReach * kReach)) {
    throw std::invalid_argument(fmt::format(
        "--at {:g},{:g},{:g}: the nearest point of an object is {:.3g} m away: expected "
        "a point within {:g} m of one",
        at.x(), at.y(), at.z(), std::sqrt(nearest), kReach));
  }
  return best;
}

}  // namespace

ObjectChoice ChooseObject(const PointCloud& cloud, const Segmentation& segmentation,
                          const ObjectHint& hint) {
  if (segmentation.size.empty())
    return {{},
            "the cloud has no region (if every point belongs to the object, use --segment no)",
            false};
  if (hint.at) return {{NearestTo(*hint.at, cloud, segmentation)}, "nearest to the given point"};
  const std::vector<Region> regions = Regions(cloud, segmentation, hint);
  ObjectChoice choice{{}, "at the position of the object in the scene"};
  for (std::size_t k = 0; k < regions.size(); ++k) {
    if (regions[k].inside > 0.5 * regions[k].points) choice.regions.push_back(static_cast<int>(k));
  }
  if (!choice.regions.empty()) return choice;
  const auto nearest = std::ranges::min_element(regions, {}, [&](const Region& region) {
    return (region.place / region.points - hint.box.center()).norm();
  });
  return {{static_cast<int>(nearest - regions.begin())},
          "nothing is at the position of the object in the scene; this region is nearest to it",
          false};
}

PointCloud Chosen(const PointCloud& cloud, const Segmentation& segmentation,
                  const std::vector<int>& regions) {
  PointCloud chosen;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int region = segmentation.region_of[i];
    if (std::ranges::find(regions, region) != regions.end()) chosen.push_back(cloud[i]);
  }
  return chosen;
}

}  // namespace palpate::study
