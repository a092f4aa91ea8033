#include "master/haptics/record/force_error.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kSmallest = 1e-12;  // [N]
constexpr double kStep = 1.01;

int BinOf(double force, int bins) {
  if (!(force > kSmallest)) return 0;
  return static_cast<int>(std::min(std::log(force / kSmallest) / std::log(kStep), bins - 1.0));
}

}  // namespace

void ForceError::Add(const Eigen::Vector3d& local, const Eigen::Vector3d& truth) noexcept {
  const double error = (local - truth).norm();
  Bin& bin = bins_[static_cast<std::size_t>(BinOf(std::max(local.norm(), truth.norm()), kBins))];
  bin.sum_of_squares += error * error;
  bin.peak = std::max(bin.peak, error);
  ++bin.ticks;
  ++count_;
}

ForceError::Summary ForceError::Above(double threshold) const noexcept {
  Summary summary;
  double sum = 0;
  for (int i = BinOf(threshold, kBins) + 1; i < kBins; ++i) {
    const Bin& bin = bins_[static_cast<std::size_t>(i)];
    sum += bin.sum_of_squares;
    summary.peak = std::max(summary.peak, bin.peak);
    summary.ticks += bin.ticks;
  }
  if (summary.ticks > 0) summary.rms = std::sqrt(sum / static_cast<double>(summary.ticks));
  return summary;
}

}  // namespace palpate
