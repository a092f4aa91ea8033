#include "slave/mechanics/linear/small_lu.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "slave/mechanics/linear/lanes.h"

namespace palpate {
namespace {

constexpr double kSmallestPivot = 1e-13;  // of the largest entry

using Values [[gnu::vector_size(64)]] = double;
using Lane [[gnu::vector_size(64), gnu::may_alias, gnu::aligned(8)]] = double;

PALPATE_INLINE Lane& At(double* row) {
  return *reinterpret_cast<Lane*>(row);
}

// The diagonal entry while it is at least a tenth of the largest one below it, else that one:
// compliances keep their diagonal, and nothing is swapped.
PALPATE_INLINE int ChoosePivot(const RowMajor& a, int k, int order) noexcept {
  std::array<double, 4> largest{};  // four at a time: a single one would wait for itself
  int i = k;
  for (; i + 4 <= order; i += 4) {
    for (std::size_t r = 0; r < largest.size(); ++r) {
      largest[r] = std::max(largest[r], std::abs(a.row(i + static_cast<int>(r))[k]));
    }
  }
  for (; i < order; ++i) largest[0] = std::max(largest[0], std::abs(a.row(i)[k]));
  const double most = *std::ranges::max_element(largest);
  if (std::abs(a.row(k)[k]) >= 0.1 * most) return k;
  int row = k;
  while (row < order - 1 && std::abs(a.row(row)[k]) != most) ++row;
  return row;
}

// Eliminates the columns [k0, k1) in all rows below; later columns only follow the row swaps.
// `multipliers`: kPanel for each row. `largest`: the largest pivot so far.
PALPATE_INLINE bool FactorizePanel(const RowMajor& a, int order, int k0, int k1,
                                   double* multipliers, double* largest) noexcept {
  for (int k = k0; k < k1; ++k) {
    const int pivot = ChoosePivot(a, k, order);
    const double entry = std::abs(a.row(pivot)[k]);
    *largest = std::max(*largest, entry);
    if (!(entry > kSmallestPivot * *largest && std::isfinite(entry))) return false;
    if (pivot != k) {
      std::swap_ranges(a.row(k) + k0, a.row(k) + a.stride, a.row(pivot) + k0);
      std::swap_ranges(multipliers + k * kPanel, multipliers + (k + 1) * kPanel,
                       multipliers + pivot * kPanel);
    }
    const Values pivot_row = At(a.row(k) + k0);
    const double inverse = 1 / a.row(k)[k];
    for (int i = k + 1; i < order; ++i) {
      const double multiplier = a.row(i)[k] * inverse;
      multipliers[i * kPanel + k - k0] = multiplier;
      At(a.row(i) + k0) -= multiplier * pivot_row;
    }
  }
  return true;
}

struct Columns {  // [begin, end), whole lanes
  int begin, end;
};

// `kRows` rows from `first` on minus their `factors` times the kPanel rows from k0 on.
template <int kRows>
PALPATE_INLINE void SubtractPanelFrom(const RowMajor& a, int first, const double* factors,
                                      long pitch, int k0, const Columns& columns) noexcept {
  for (int j = columns.begin; j < columns.end; j += kLane) {
    Values sums[kRows];
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) sums[r] = At(a.row(first + r) + j);
    for (int k = 0; k < kPanel; ++k) {
      const Values row = At(a.row(k0 + k) + j);
#pragma GCC unroll 4
      for (int r = 0; r < kRows; ++r) sums[r] -= factors[r * pitch + k] * row;
    }
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) At(a.row(first + r) + j) = sums[r];
  }
}

// Rows [first, last) minus their `factors`, kPanel for each and `pitch` apart, times the kPanel
// rows from k0 on, as many rows at a time as registers hold.
PALPATE_INLINE void SubtractPanel(const RowMajor& a, int first, int last, const double* factors,
                                  long pitch, int k0, const Columns& columns) noexcept {
  for (; first + 4 <= last; first += 4, factors += 4 * pitch) {
    SubtractPanelFrom<4>(a, first, factors, pitch, k0, columns);
  }
  for (; first + 2 <= last; first += 2, factors += 2 * pitch) {
    SubtractPanelFrom<2>(a, first, factors, pitch, k0, columns);
  }
  if (first < last) SubtractPanelFrom<1>(a, first, factors, pitch, k0, columns);
}

// The columns from `begin` on without the trailing zeros of the rows [k0, k1): unit vectors on the
// right stay cheap.
PALPATE_INLINE Columns NonzeroColumns(const RowMajor& a, int k0, int k1, int begin) noexcept {
  int end = a.stride;
  for (; end > begin; end -= kLane) {
    for (int k = k0; k < k1; ++k) {
      const double* row = a.row(k) + end - kLane;
      for (int l = 0; l < kLane; ++l) {
        if (row[l] != 0) return {begin, end};
      }
    }
  }
  return {begin, end};
}

// Rows [k0, k1) := L^-1 rows.
PALPATE_INLINE void ForwardSubstitute(const RowMajor& a, int k0, int k1, const double* multipliers,
                                      const Columns& columns) noexcept {
  for (int j = columns.begin; j < columns.end; j += kLane) {
    for (int k = k0 + 1; k < k1; ++k) {
      Values sum = At(a.row(k) + j);
      for (int i = k0; i < k; ++i) sum -= multipliers[k * kPanel + i - k0] * At(a.row(i) + j);
      At(a.row(k) + j) = sum;
    }
  }
}

// B := U^-1 B in panels from the last row on; the one that is not full has no rows above it.
PALPATE_INLINE void BackSubstitute(const RowMajor& a, int order) noexcept {
  const int begin = PaddedTo(kLane, order);
  for (int k1 = order; k1 > 0; k1 -= kPanel) {
    const int k0 = std::max(k1 - kPanel, 0);
    for (int k = k1 - 1; k >= k0; --k) {
      const double* factors = a.row(k);
      const double inverse = 1 / factors[k];
      for (int j = begin; j < a.stride; j += kLane) {
        Values sum = At(a.row(k) + j);
        for (int i = k + 1; i < k1; ++i) sum -= factors[i] * At(a.row(i) + j);
        At(a.row(k) + j) = inverse * sum;
      }
    }
    SubtractPanel(a, 0, k0, a.data + k0, a.stride, k0, {begin, a.stride});
  }
}

}  // namespace

PALPATE_DISPATCHED bool SolveInPlace(const RowMajor& a, int order, double* scratch) noexcept {
  double largest = 0;
  for (int k0 = 0; k0 < order; k0 += kPanel) {
    const int k1 = std::min(k0 + kPanel, order);
    if (!FactorizePanel(a, order, k0, k1, scratch, &largest)) return false;
    const Columns columns = NonzeroColumns(a, k0, k1, PaddedTo(kLane, k1));
    ForwardSubstitute(a, k0, k1, scratch, columns);
    SubtractPanel(a, k1, order, scratch + k1 * kPanel, kPanel, k0, columns);
  }
  BackSubstitute(a, order);
  return true;
}

}  // namespace palpate
