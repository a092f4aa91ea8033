#include "slave/commands/verify/card_statistics.h"

#include <algorithm>
#include <limits>

#include "slave/commands/verify/card_words.h"

namespace palpate {

using Eigen::Vector3d;

std::map<int, std::vector<const MatchedState*>> ByLoad(
    const std::vector<const MatchedState*>& states) {
  std::map<int, std::vector<const MatchedState*>> loads;
  for (const MatchedState* one : states) loads[one->load].push_back(one);
  return loads;
}

std::optional<std::pair<Vector3d, Interval>> MeanError(const std::vector<Vector3d>& errors) {
  constexpr std::size_t kParts = 10;
  const std::size_t parts = std::min(kParts, errors.size());
  if (parts < 3) return std::nullopt;
  std::vector<Vector3d> means(parts, Vector3d::Zero());
  std::vector<double> counts(parts, 0);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const std::size_t part = i * parts / errors.size();
    means[part] += errors[i];
    ++counts[part];
  }
  Vector3d mean = Vector3d::Zero(), spread = Vector3d::Zero();
  const auto n = static_cast<double>(parts);
  for (std::size_t i = 0; i < parts; ++i) mean += means[i] / counts[i] / n;
  for (std::size_t i = 0; i < parts; ++i) spread += (means[i] / counts[i] - mean).cwiseAbs2();
  const double reach = StudentReach(n - 1) * std::sqrt(spread.sum() / (n * (n - 1)));
  const double size = mean.norm();
  return std::pair{mean, Interval{size, std::fmax(0, size - reach), size + reach}};
}

Interval Inverse(const Interval& interval) {
  return {1 / interval.value, 1 / interval.high,
          interval.low > 0 ? 1 / interval.low : std::numeric_limits<double>::infinity()};
}

Interval Scale::Both() const {
  return {std::sqrt(forth.value * back.value), std::fmin(forth.low, back.low),
          std::fmax(forth.high, back.high)};
}

Finding Scale::Judge(double tolerance) const {
  const double low = 1 - tolerance, high = 1 + tolerance;
  const Finding a = Judged(forth, low, high), b = Judged(back, low, high);
  if (a == Finding::kRight || b == Finding::kRight) return Finding::kRight;
  const bool agree = (forth.high < low) == (back.high < low);
  return a == Finding::kWrong && b == Finding::kWrong && agree ? Finding::kWrong : Finding::kOpen;
}

}  // namespace palpate
