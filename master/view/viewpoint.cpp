#include "master/view/viewpoint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kAside = 20 * std::numbers::pi / 180;      // off the side view
constexpr double kElevation = 24 * std::numbers::pi / 180;  // above the horizon
constexpr double kUpright = 0.05;                           // horizontal share of a direction [-]

using Colour = std::array<double, 3>;

// Pale grey over orange to dark purple: darker is larger, also for colour-blind viewers.
constexpr std::array<Colour, 5> kStops{{
    {236, 239, 243},
    {250, 214, 145},
    {242, 142, 75},
    {205, 62, 78},
    {112, 28, 92},
}};

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

double RoundedUp(double value, double floor) {
  if (!(value > floor)) value = floor;
  if (!std::isfinite(value)) value = 1e300;
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 4.0, 6.0, 8.0}) {
    if (value <= step * decade * (1 + 1e-9)) return step * decade;
  }
  return 10 * decade;
}

std::string ColourOf(double share, double light) {
  const double at = std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double rest = at - static_cast<double>(below);
  std::array<unsigned, 3> rgb{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double mixed = (1 - rest) * kStops[below][i] + rest * kStops[below + 1][i];
    rgb[i] = static_cast<unsigned>(std::lround(std::clamp(light, 0.0, 1.0) * mixed));
  }
  return Formatted("#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
}

std::string Readable(double value) {
  return Formatted("%.3g", value);
}

}  // namespace palpate
