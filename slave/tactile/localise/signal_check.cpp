#include "slave/tactile/localise/signal_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate {
namespace {

constexpr float kLowest = 0, kHighest = 4095;  // of a 12-bit converter [counts]
constexpr double kStuck = 1e-6;                // [counts]
constexpr double kMoved = 4;                   // thresholds
constexpr int kMostDead = 9;                   // where more are at rest, nothing is said of them

// The two electrodes nearest to electrode `i`.
std::array<int, 2> NearestTwo(const ElectrodeLayout& layout, std::size_t i) {
  std::array<int, kElectrodeCount> order{};
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<int>(k);
  const auto distance = [&](int k) {
    return (layout.p_F[static_cast<std::size_t>(k)] - layout.p_F[i]).norm();
  };
  // The nearest of all is the electrode itself, wherever others sit on the same place.
  std::swap(order[0], order[i]);
  std::partial_sort(order.begin() + 1, order.begin() + 3, order.end(),
                    [&](int a, int b) { return distance(a) < distance(b); });
  return {order[1], order[2]};
}

}  // namespace

SignalCheck::SignalCheck(const ElectrodeLayout& layout, double threshold)
    : moved_(kMoved * threshold) {
  for (std::size_t i = 0; i < kElectrodeCount; ++i) nearest_[i] = NearestTwo(layout, i);
}

SignalFlaws SignalCheck::Check(const TactileSignals& change,
                               const FingerReading& raw) const noexcept {
  SignalFlaws flaws;
  const auto is_finite = [](double count) { return std::isfinite(count); };
  flaws.finite = std::all_of(change.begin(), change.end(), is_finite) &&
                 std::all_of(raw.electrodes.begin(), raw.electrodes.end(), is_finite);
  const auto has_moved = [&](int k) {
    return std::abs(change[static_cast<std::size_t>(k)]) > moved_;
  };
  const auto is_stuck = [](double count) { return std::abs(count) < kStuck; };
  const auto stuck = std::count_if(change.begin(), change.begin() + kElectrodeCount, is_stuck);
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    flaws.saturated |= raw.electrodes[i] <= kLowest || raw.electrodes[i] >= kHighest;
    flaws.dead[i] = is_stuck(change[i]) && stuck <= kMostDead && has_moved(nearest_[i][0]) &&
                    has_moved(nearest_[i][1]);
    flaws.any_dead |= flaws.dead[i];
  }
  return flaws;
}

}  // namespace palpate
