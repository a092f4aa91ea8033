#include "shared/telemetry/latency_histogram.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kMinTime = 0.01;  // [us]
constexpr double kStep = 1.02;

}  // namespace

void LatencyHistogram::Add(double us) noexcept {
  if (!(us >= 0) || std::isinf(us)) us = 0;
  max_ = std::max(max_, us);
  const double bin = us <= kMinTime ? 0 : std::ceil(std::log(us / kMinTime) / std::log(kStep));
  ++bins_[static_cast<std::size_t>(std::min(bin, static_cast<double>(kBins - 1)))];
  ++count_;
}

double LatencyHistogram::Quantile(double q) const noexcept {
  if (count_ == 0) return 0;
  const double wanted = std::clamp(q, 0.0, 1.0) * static_cast<double>(count_);
  double seen = 0;
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    seen += bins_[i];
    if (seen >= wanted) return std::min(max_, kMinTime * std::pow(kStep, static_cast<double>(i)));
  }
  return max_;
}

}  // namespace palpate
