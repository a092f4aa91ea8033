#include "slave/study/clouds/point_tree.h"

#include <cmath>
#include <stdexcept>

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace palpate::study {
namespace {

pcl::PointXYZ ToPcl(const Eigen::Vector3d& p) {
  const Eigen::Vector3f q = p.cast<float>();
  return {q.x(), q.y(), q.z()};
}

}  // namespace

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

}  // namespace palpate::study
