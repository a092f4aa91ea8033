#include "slave/study/clouds/support_plane.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Eigenvalues>
#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include "shared/statistics/robust.h"

namespace palpate::study {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

// n . p + d = 0; nullopt-like: n is zero where no plane was found.
Eigen::Vector4d LargestPlane(const Cloud::Ptr& cloud, double tolerance) {
  pcl::SACSegmentation<pcl::PointXYZ> search;
  search.setModelType(pcl::SACMODEL_PLANE);
  search.setMethodType(pcl::SAC_RANSAC);
  search.setOptimizeCoefficients(true);
  search.setDistanceThreshold(tolerance);
  search.setMaxIterations(500);
  search.setInputCloud(cloud);
  pcl::PointIndices inliers;
  pcl::ModelCoefficients plane;
  search.segment(inliers, plane);
  if (plane.values.size() != 4) return Eigen::Vector4d::Zero();
  return Eigen::Map<const Eigen::Vector4f>(plane.values.data()).cast<double>();
}

// The middle along each axis.
Eigen::Vector3d Middle(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d middle;
  std::vector<double> values(points.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::ranges::transform(points, values.begin(), [&](const auto& p) { return p[axis]; });
    middle[axis] = MedianOf(values);
  }
  return middle;
}

// Four sigma of the points' spread along the narrower of the plane's two directions. Far points
// that happen to lie in the plane of an object's face do not widen it.
double Extent(std::vector<Eigen::Vector3d> points) {
  const Eigen::Vector3d middle = Middle(points);
  std::vector<double> distances;
  for (const auto& p : points) distances.push_back((p - middle).norm());
  const double far = 3 * MedianOf(distances);
  std::erase_if(points, [&](const auto& p) { return (p - middle).norm() > far; });
  const auto n = static_cast<double>(points.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p / n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& p : points) covariance += (p - mean) * (p - mean).transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return 4 * std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
}

}  // namespace

double DepthNoise(double z) noexcept {
  return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
}

std::vector<bool> InSupportPlanes(std::span<const Eigen::Vector3d> points,
                                  const SupportPlaneOptions& options) {
  // What it finds too little of is no news to the user.
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  std::vector<bool> in_plane(points.size(), false);
  if (points.empty()) return in_plane;
  const double farthest = 2 * std::abs(Middle(points).z());
  for (int k = 0; k < options.planes; ++k) {
    auto rest = std::make_shared<Cloud>();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3f p = points[i].cast<float>();
      if (!in_plane[i]) rest->push_back({p.x(), p.y(), p.z()});
    }
    const double wanted = options.share * static_cast<double>(points.size());
    if (rest->size() < 3 || static_cast<double>(rest->size()) < wanted) break;
    const Eigen::Vector4d plane = LargestPlane(rest, options.tolerance);
    if (plane.isZero()) break;
    std::vector<std::size_t> inliers;
    std::vector<Eigen::Vector3d> places;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double distance = std::abs(plane.head<3>().dot(points[i]) + plane[3]);
      const double tolerance = std::max(
          options.tolerance, 3 * DepthNoise(std::clamp(points[i].z(), -farthest, farthest)));
      if (in_plane[i] || !(distance <= tolerance)) continue;
      inliers.push_back(i);
      places.push_back(points[i]);
    }
    if (static_cast<double>(inliers.size()) < wanted || Extent(places) < options.extent) break;
    for (const std::size_t i : inliers) in_plane[i] = true;
  }
  return in_plane;
}

}  // namespace palpate::study
