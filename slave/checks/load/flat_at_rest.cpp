#include "slave/checks/load/flat_at_rest.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace palpate {
namespace {

// Points of a fit [-]. [derived: four unknowns, and two to spare]
constexpr int kMinShapePoints = 6;
// Smallest deviation that differs from noise [sigma]. [tuned: flat_at_rest_test]
constexpr double kSigmas = 4;

bool Counts(const SurfacePoint& point, double radius) noexcept {
  return point.seen && point.p_S_rest.head<2>().norm() <= radius && point.covariance(2, 2) > 0 &&
         std::isfinite(point.p_S_rest.z());
}

}  // namespace

RestShape RestShapeOf(const std::vector<SurfacePoint>& points_O, double radius) noexcept {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d slope = Eigen::Vector4d::Zero();
  double square = 0, variance = 0;
  RestShape shape;
  for (const SurfacePoint& point : points_O) {
    if (!Counts(point, radius)) continue;
    const Eigen::Vector2d x = point.p_S_rest.head<2>() / radius;
    const double within = 1 - x.squaredNorm(), z = point.p_S_rest.z();
    const Eigen::Vector4d row(within * within, 1, x.x(), x.y());
    normal += row * row.transpose();
    slope += z * row;
    square += z * z;
    variance += point.covariance(2, 2);
    ++shape.points;
  }
  if (shape.points < kMinShapePoints) return {};
  const Eigen::Matrix4d inverse = (normal + 1e-9 * Eigen::Matrix4d::Identity()).inverse();
  const Eigen::Matrix3d plane = normal.bottomRightCorner<3, 3>();
  const double flat = slope.tail<3>().dot(plane.ldlt().solve(slope.tail<3>()));
  shape.sigma_rms = std::sqrt(variance / shape.points);
  shape.height = inverse.row(0).dot(slope);
  shape.sigma_height = std::sqrt(inverse(0, 0)) * shape.sigma_rms;
  shape.rms = std::sqrt(std::max(0.0, square - flat) / (shape.points - 3));
  return shape;
}

bool IsFlat(const RestShape& shape, double thickness) noexcept {
  const double most = LoadLimits::kFlatHeight * thickness;
  return std::abs(shape.height) <= std::max(most, kSigmas * shape.sigma_height) &&
         shape.rms <= std::max(most / 2, kSigmas * shape.sigma_rms);
}

}  // namespace palpate
