#include "slave/study/clouds/colour_growth.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing_rgb.h>

namespace palpate::study {

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

}  // namespace palpate::study
