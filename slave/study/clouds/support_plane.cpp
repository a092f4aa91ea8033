#include "slave/study/clouds/support_plane.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <pcl/common/centroid.h>
#include <pcl/segmentation/sac_segmentation.h>

#include "slave/statistics/robust.h"

namespace palpate::study {
namespace {

constexpr int kPlanes = 3;
constexpr double kShare = 0.1;   // smallest share of the points in a supporting plane
constexpr double kExtent = 0.3;  // [m]

// Returns the median along each axis.
Eigen::Vector3f Middle(const PointCloud& cloud, const pcl::Indices& points) {
  Eigen::Vector3f middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    for (const auto i : points) values.push_back(cloud[i].data[axis]);
    middle[axis] = MedianOf(values);
  }
  return middle;
}

// Returns four sigma of the points' spread along the narrower direction of the plane [m], without
// points that are farther from the centre than three times the median.
double Extent(const PointCloud& cloud, pcl::Indices points) {
  const Eigen::Vector3f middle = Middle(cloud, points);
  const auto distance = [&](auto i) { return (cloud[i].getVector3fMap() - middle).norm(); };
  std::vector<float> distances;
  for (const auto i : points) distances.push_back(distance(i));
  const float far = 3 * MedianOf(distances);
  std::erase_if(points, [&](auto i) { return distance(i) > far; });
  Eigen::Matrix3d covariance;
  Eigen::Vector4d centroid;
  pcl::computeMeanAndCovarianceMatrix(cloud, points, covariance, centroid);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return 4 * std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
}

// n . p + d = 0 as n, d; zero: no plane was found.
Eigen::Vector4d LargestPlane(const PointCloud::ConstPtr& cloud, const pcl::Indices& points,
                             double tolerance) {
  pcl::SACSegmentation<PointCloud::PointType> search;
  search.setModelType(pcl::SACMODEL_PLANE);
  search.setMethodType(pcl::SAC_RANSAC);
  search.setOptimizeCoefficients(true);
  search.setDistanceThreshold(tolerance);
  search.setMaxIterations(500);
  search.setInputCloud(cloud);
  search.setIndices(std::make_shared<pcl::Indices>(points));
  pcl::PointIndices inliers;
  pcl::ModelCoefficients plane;
  search.segment(inliers, plane);
  if (plane.values.size() != 4) return Eigen::Vector4d::Zero();
  return Eigen::Map<const Eigen::Vector4f>(plane.values.data()).cast<double>();
}

}  // namespace

double DepthNoise(double z) noexcept {
  return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
}

pcl::Indices TakeSupportPlanes(const PointCloud::ConstPtr& cloud, double tolerance,
                               pcl::Indices* points) {
  pcl::Indices supports;
  if (points->empty()) return supports;
  const double wanted = kShare * static_cast<double>(points->size());
  const double farthest = 2 * std::abs(Middle(*cloud, *points).z());
  for (int k = 0; k < kPlanes && points->size() >= 3; ++k) {
    const Eigen::Vector4d plane = LargestPlane(cloud, *points, tolerance);
    if (plane.isZero()) break;
    pcl::Indices rest = *points;
    const auto inside = std::ranges::stable_partition(rest, [&](auto i) {
      const Eigen::Vector3d p = (*cloud)[i].getVector3fMap().template cast<double>();
      const double noise = DepthNoise(std::clamp(p.z(), -farthest, farthest));
      return std::abs(plane.head<3>().dot(p) + plane[3]) > std::max(tolerance, 3 * noise);
    });
    const pcl::Indices in_plane(inside.begin(), inside.end());
    const bool is_large = static_cast<double>(in_plane.size()) >= wanted;
    if (!is_large || Extent(*cloud, in_plane) < kExtent) break;
    supports.insert(supports.end(), in_plane.begin(), in_plane.end());
    rest.resize(rest.size() - in_plane.size());
    *points = std::move(rest);
  }
  return supports;
}

}  // namespace palpate::study
