#include "slave/tactile/localise/direction_mean.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace palpate {
namespace {

constexpr float kLowest = 0, kHighest = 4095;  // [counts] [derived: a 12-bit converter]
constexpr double kStuck = 1e-6;                // [counts]
constexpr double kMoved = 4 * kActiveCounts;   // [counts]
// Largest number of dead electrodes for a direction [-]. [tuned:
// FindsAContactOverTheElectrodeThatFalls]
constexpr int kMaxDead = 9;

// The two electrodes nearest to electrode `i`.
std::array<int, 2> NearestTwo(const ElectrodeLayout& layout, std::size_t i) {
  std::array<int, kElectrodeCount> order{};
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<int>(k);
  const auto distance = [&](int k) {
    return (layout.p_F[static_cast<std::size_t>(k)] - layout.p_F[i]).norm();
  };
  // Puts the electrode itself first, even if others are at the same position.
  std::swap(order[0], order[i]);
  std::partial_sort(order.begin() + 1, order.begin() + 3, order.end(),
                    [&](int a, int b) { return distance(a) < distance(b); });
  return {order[1], order[2]};
}

// Returns x_i, the change beyond that expected from the pressure.
double BeyondPressure(const TactileSignals& change, std::size_t electrode) noexcept {
  const double pressure = static_cast<double>(change[kElectrodeCount + 1]);
  return static_cast<double>(change[electrode]) - kPressureShare * pressure;
}

// Width of the transition between formulas [rad]. [tuned: ErrsLessThanThePaper]
constexpr double kBlend = 8 * std::numbers::pi / 180;
constexpr double kCancelled = 1e-9;  // of the intensities

}  // namespace

SignalCheck::SignalCheck(const ElectrodeLayout& layout) {
  for (std::size_t i = 0; i < kElectrodeCount; ++i) nearest_[i] = NearestTwo(layout, i);
}

SignalFlaws SignalCheck::Check(const TactileSignals& change,
                               const FingerReading& raw) const noexcept {
  SignalFlaws flaws;
  const auto is_finite = [](double count) { return std::isfinite(count); };
  flaws.finite = std::all_of(change.begin(), change.end(), is_finite) &&
                 std::all_of(raw.channels.begin(), raw.channels.end(), is_finite);
  const auto has_moved = [&](int k) {
    return std::abs(change[static_cast<std::size_t>(k)]) > kMoved;
  };
  const auto is_stuck = [](double count) { return std::abs(count) < kStuck; };
  const auto stuck = std::count_if(change.begin(), change.begin() + kElectrodeCount, is_stuck);
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    flaws.saturated |= raw.channels[i] <= kLowest || raw.channels[i] >= kHighest;
    flaws.dead[i] = is_stuck(change[i]) && stuck <= kMaxDead && has_moved(nearest_[i][0]) &&
                    has_moved(nearest_[i][1]);
    flaws.any_dead |= flaws.dead[i];
  }
  return flaws;
}

Intensities PressureWeighted(const TactileSignals& change, const SignalFlaws& flaws) noexcept {
  Intensities intensities;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const double fall = -BeyondPressure(change, i);
    if (fall > kActiveCounts && !flaws.dead[i]) intensities.Set(i, fall);
  }
  return intensities;
}

DirectionMean::DirectionMean(const ElectrodeLayout& layout, double radius) : surface_{radius} {
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const auto p_F = surface_.Project(layout.p_F[i]);
    if (!p_F) {
      throw std::invalid_argument(std::string("E").append(std::to_string(i + 1)) +
                                  " is on the finger's axis: it has no direction");
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
