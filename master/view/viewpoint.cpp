#include "master/view/viewpoint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate {
namespace {

constexpr double kAside = 20 * std::numbers::pi / 180;      // off the side view
constexpr double kElevation = 24 * std::numbers::pi / 180;  // above the horizon
constexpr double kUpright = 0.05;                           // horizontal share of a direction [-]

}  // namespace

Viewpoint Viewpoint::Across(const Eigen::Vector3d& along) {
  const double flat = along.head<2>().norm();
  const bool lies = flat > kUpright * along.norm() && std::isfinite(along.norm());
  double azimuth = (lies ? std::atan2(along.y(), along.x()) : 0) + kAside;
  if (std::cos(azimuth) < 0) azimuth += std::numbers::pi;  // x runs to the right
  const Eigen::Vector3d right(std::cos(azimuth), std::sin(azimuth), 0);
  const Eigen::Vector3d away(-std::sin(azimuth), std::cos(azimuth), 0);
  const Eigen::Vector3d z(0, 0, 1);
  return {right, std::cos(kElevation) * z + std::sin(kElevation) * away,
          std::sin(kElevation) * z - std::cos(kElevation) * away};
}

Viewpoint Viewpoint::Front() {
  return {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
}

void Viewpoint::Fit(std::span<const Eigen::Vector3d> points, const Eigen::Vector2d& corner,
                    const Eigen::Vector2d& size) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(kInf, kInf), high(-kInf, -kInf);
  for (const Eigen::Vector3d& point : points) {
    low = low.cwiseMin(Across2d(point));
    high = high.cwiseMax(Across2d(point));
  }
  if (points.empty()) low = high = {0, 0};
  const Eigen::Vector2d extent = high - low;
  const double scale = std::min(size.x() / extent.x(), size.y() / extent.y());
  scale_ = std::isfinite(scale) ? scale : 1;
  origin_ = corner + size / 2 - scale_ * (low + high) / 2;
}

}  // namespace palpate
