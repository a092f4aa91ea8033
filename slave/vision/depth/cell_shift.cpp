#include "slave/vision/depth/cell_shift.h"

#include <algorithm>
#include <cmath>

namespace palpate {

CellShift::CellShift(int edge, double sigma)
    : sigma_(sigma * RestDepth::kFractions),
      changes_(static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge)),
      sample_(changes_.size()) {}

std::optional<CellShift::Mean> CellShift::Of(const cv::Mat& depth, const RestDepth& rest,
                                             const DepthCell& cell, int least) noexcept {
  auto end = changes_.begin();
  for (int v = cell.row; v < cell.row + cell.edge; ++v) {
    const auto* counts = depth.ptr<std::uint16_t>(v);
    const std::int32_t* at_rest = rest.row(v);
    for (int u = cell.column; u < cell.column + cell.edge; ++u) {
      if (at_rest[u] == 0 || !rest.IsMeasured(counts[u])) continue;
      *end++ = RestDepth::kFractions * counts[u] - at_rest[u];
    }
  }
  const auto begin = changes_.begin();
  const auto count = end - begin;
  if (count < std::max(1, least)) return std::nullopt;
  // The median only says where to look: a third of the pixels, of every row and column some, do.
  constexpr std::ptrdiff_t kPlenty = 128;
  const std::ptrdiff_t step = count >= kPlenty ? 3 : 1;
  const auto first = sample_.begin();
  auto last = first;
  for (std::ptrdiff_t i = 0; i < count; i += step) *last++ = begin[i];
  const auto median = first + (last - first) / 2;
  std::nth_element(first, median, last);
  const auto lower = first + (last - first) / 4;
  const auto upper = first + 3 * (last - first) / 4;
  if (lower < median) std::nth_element(first, lower, median);
  if (median < upper) std::nth_element(median + 1, upper, last);
  // One sigma of a normal distribution, by both quartiles, or by the closer one where outliers have
  // got hold of the other.
  const double both = 0.7413 * (*upper - *lower);
  const double closer = 1.4826 * std::min(*median - *lower, *upper - *median);
  const double width = 3 * std::max(sigma_, std::min(both, closer + 2 * sigma_));
  double sum = 0;
  double squares = 0;
  int used = 0;
  for (auto it = begin; it != end; ++it) {
    const double off = *it - *median;
    const double near = std::abs(off) <= width ? 1 : 0;
    sum += near * off;
    squares += near * off * off;
    used += near != 0 ? 1 : 0;
  }
  const double mean = sum / used;
  return Mean{(*median + mean) / RestDepth::kFractions,
              std::sqrt(std::max(0.0, squares / used - mean * mean)) / RestDepth::kFractions,
              static_cast<int>(count)};
}

}  // namespace palpate
