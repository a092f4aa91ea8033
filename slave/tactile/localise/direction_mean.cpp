#include "slave/tactile/localise/direction_mean.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>

namespace palpate {
namespace {

constexpr double kBlend = 8 * std::numbers::pi / 180;  // [rad]
constexpr double kCancelled = 1e-9;                    // of the intensities

}  // namespace

DirectionMean::DirectionMean(const ElectrodeLayout& layout, double radius) : surface_{radius} {
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const auto p_F = surface_.Project(layout.p_F[i]);
    if (!p_F) {
      throw std::invalid_argument(std::string("E").append(std::to_string(i + 1)) +
                                  " sits on the finger's axis: it has no direction");
    }
    n_F_[i] = surface_.Normal(*p_F);
    axis_x_[i] = std::min(p_F->x(), 0.0);
  }
}

std::optional<ContactDirection> DirectionMean::Mean(const Intensities& intensities) const noexcept {
  Eigen::Vector3d n(0, 0, 0);
  double axis_x = 0;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    n += intensities.of[i] * n_F_[i];
    axis_x += intensities.of[i] * axis_x_[i];
  }
  const double length = n.stableNorm();
  if (!(length > kCancelled * intensities.total) || !std::isfinite(length)) return std::nullopt;
  return ContactDirection{n / length, axis_x / intensities.total};
}

Eigen::Vector3d DirectionMean::PlaceOf(const ContactDirection& direction) const noexcept {
  const double r = surface_.radius;
  const Eigen::Vector3d& n = direction.n_F;
  const double elevation = std::asin(std::clamp(n.x(), -1.0, 1.0));
  const double on_tip = std::clamp(elevation / kBlend, 0.0, 1.0);
  const double x = on_tip * r * n.x() + (1 - on_tip) * direction.axis_x;
  const double from_axis = x > 0 ? std::sqrt(std::max(r * r - x * x, 0.0)) : r;
  const double across = std::hypot(n.y(), n.z());
  if (!(across > 0)) return {r, 0, 0};
  return {x, from_axis * n.y() / across, from_axis * n.z() / across};
}

}  // namespace palpate
