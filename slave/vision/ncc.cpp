#include "slave/vision/ncc.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate {
namespace {

constexpr std::size_t kNoOverflow = 512;  // products of two levels below 2048 that fit in 32 bits

std::int64_t Dot(const std::int16_t* a, const std::int16_t* b, std::size_t count) noexcept {
  std::int64_t sum = 0;
  while (count > 0) {
    const std::size_t part = std::min(count, kNoOverflow);
    std::int32_t part_sum = 0;  // compilers make multiply-and-add instructions of this
    for (std::size_t i = 0; i < part; ++i) part_sum += static_cast<std::int32_t>(a[i]) * b[i];
    sum += part_sum;
    a += part, b += part, count -= part;
  }
  return sum;
}

std::int64_t Sum(const std::int16_t* a, std::size_t count) noexcept {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += a[i];
  return sum;
}

}  // namespace

Ncc::Ncc(GreyPatch pattern) : pattern_(std::move(pattern)) {
  const std::int16_t* levels = pattern_.levels.data();
  const std::size_t size = pattern_.levels.size();
  count_ = static_cast<std::int64_t>(size);
  sum_ = Sum(levels, size);
  variance_ = count_ * Dot(levels, levels, size) - sum_ * sum_;
  if (size == 0) throw std::invalid_argument("the template is empty");
  if (variance_ == 0) throw std::invalid_argument("the template has no contrast");
}

const ScoreMap& Ncc::Match(const GreyPatch& window) {
  map_.width = std::max(0, window.width - pattern_.width + 1);
  map_.height = std::max(0, window.height - pattern_.height + 1);
  if (map_.width == 0 || map_.height == 0) map_.width = map_.height = 0;
  map_.scores.resize(static_cast<std::size_t>(map_.width) * static_cast<std::size_t>(map_.height));
  row_sum_.resize(static_cast<std::size_t>(window.height));
  row_square_.resize(static_cast<std::size_t>(window.height));
  for (int x = 0; x < map_.width; ++x) {
    SumRows(window, x);
    MatchColumn(window, x);
  }
  return map_;
}

// Sums over the columns x ... x + w - 1 of each row, carried on from the column before.
void Ncc::SumRows(const GreyPatch& window, int x) {
  const auto width = static_cast<std::size_t>(pattern_.width);
  for (int y = 0; y < window.height; ++y) {
    const std::int16_t* row = window.Row(y) + x;
    std::int64_t& sum = row_sum_[static_cast<std::size_t>(y)];
    std::int64_t& square = row_square_[static_cast<std::size_t>(y)];
    if (x == 0) {
      sum = Sum(row, width);
      square = Dot(row, row, width);
    } else {
      const int gone = row[-1], come = row[width - 1];
      sum += come - gone;
      square += come * come - gone * gone;
    }
  }
}

// The columns x ... x + w - 1 are copied to a strip of their own, in which the pixels under the
// template lie in one piece at every height: one long dot product per place.
void Ncc::MatchColumn(const GreyPatch& window, int x) {
  const auto width = static_cast<std::size_t>(pattern_.width);
  const auto height = static_cast<std::size_t>(window.height);
  strip_.Resize(pattern_.width, window.height);
  for (int y = 0; y < window.height; ++y) {
    std::copy_n(window.Row(y) + x, width, strip_.Row(y));
  }
  std::int64_t sum = 0, square = 0;
  for (std::size_t y = 0; y < height; ++y) {
    sum += row_sum_[y];
    square += row_square_[y];
    const std::size_t rows = static_cast<std::size_t>(pattern_.height);
    if (y + 1 < rows) continue;
    const std::size_t top = y + 1 - rows;
    const std::int64_t product =
        Dot(pattern_.levels.data(), strip_.levels.data() + top * width, rows * width);
    const std::int64_t covariance = count_ * product - sum_ * sum;
    const std::int64_t variance = count_ * square - sum * sum;
    map_.scores[top * static_cast<std::size_t>(map_.width) + static_cast<std::size_t>(x)] =
        variance > 0 ? static_cast<double>(covariance) /
                           std::sqrt(static_cast<double>(variance_) * static_cast<double>(variance))
                     : kNoMatch;
    sum -= row_sum_[top];
    square -= row_square_[top];
  }
}

}  // namespace palpate
