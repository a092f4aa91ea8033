#include "slave/mechanics/linear/dense_factor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "slave/mechanics/linear/lanes.h"

namespace palpate {
namespace {

constexpr double kMinPivot = 1e-13;  // of the largest entry
constexpr int kPanel = kLane8;       // pivots that are eliminated together

using Values [[gnu::vector_size(64)]] = double;
using Lane [[gnu::vector_size(64), gnu::may_alias, gnu::aligned(8)]] = double;

// Returns by value, see lanes.h.
PALPATE_INLINE Values Load(const double* from) {
  return *reinterpret_cast<const Lane*>(from);
}
PALPATE_INLINE void Store(double* to, const Values& values) {
  *reinterpret_cast<Lane*>(to) = values;
}

// Multipliers of a panel's rows, `pitch` apart.
struct Factors {
  const double* data;
  long pitch;
  [[nodiscard]] const double* row(int i) const { return data + i * pitch; }
};

struct Columns {  // [begin, end), whole lanes
  int begin, end;
};

// Returns the diagonal entry if it is at least a tenth of the largest one below it, else the row of
// that one. For compliances the diagonal is kept, so no rows are swapped.
PALPATE_INLINE int ChoosePivot(const RowMajor& a, int k, int order) noexcept {
  std::array<double, 4>
      largest{};  // four independent maxima: a single one would serialise the loop
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

// Eliminates the columns [k0, k1) in all rows below and leaves the inverse pivots on the diagonal;
// later columns only follow the row swaps.
// `multipliers`: kPanel for each row. `largest`: the largest pivot so far.
PALPATE_INLINE bool FactorizePanel(const RowMajor& a, int order, int k0, int k1,
                                   double* multipliers, int* pivots, double* largest) noexcept {
  for (int k = k0; k < k1; ++k) {
    const int pivot = ChoosePivot(a, k, order);
    const double entry = std::abs(a.row(pivot)[k]);
    *largest = std::max(*largest, entry);
    if (!(entry > kMinPivot * *largest && std::isfinite(entry))) return false;
    pivots[k] = pivot;
    if (pivot != k) {
      std::swap_ranges(a.row(k), a.row(k) + a.stride, a.row(pivot));
      std::swap_ranges(multipliers + k * kPanel, multipliers + (k + 1) * kPanel,
                       multipliers + pivot * kPanel);
    }
    const Values pivot_row = Load(a.row(k) + k0);
    const double inverse = 1 / a.row(k)[k];
    for (int i = k + 1; i < order; ++i) {
      const double multiplier = a.row(i)[k] * inverse;
      multipliers[i * kPanel + k - k0] = multiplier;
      Store(a.row(i) + k0, Load(a.row(i) + k0) - multiplier * pivot_row);
    }
    a.row(k)[k] = inverse;
  }
  return true;
}

// Subtracts `factors` times the kPanel rows from k0 on from `kRows` rows from `first` on.
template <int kRows>
PALPATE_INLINE void SubtractPanelFrom(const RowMajor& a, int first, const Factors& factors, int k0,
                                      const Columns& columns) noexcept {
  for (int j = columns.begin; j < columns.end; j += kLane8) {
    Values sums[kRows];
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) sums[r] = Load(a.row(first + r) + j);
    for (int k = 0; k < kPanel; ++k) {
      const Values row = Load(a.row(k0 + k) + j);
#pragma GCC unroll 4
      for (int r = 0; r < kRows; ++r) sums[r] -= factors.row(first + r)[k] * row;
    }
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) Store(a.row(first + r) + j, sums[r]);
  }
}

// Subtracts `factors` times the kPanel rows from k0 on from the rows [first, last), as many at a
// time as fit in registers.
PALPATE_INLINE void SubtractPanel(const RowMajor& a, int first, int last, const Factors& factors,
                                  int k0, const Columns& columns) noexcept {
  for (; first + 4 <= last; first += 4) SubtractPanelFrom<4>(a, first, factors, k0, columns);
  for (; first + 2 <= last; first += 2) SubtractPanelFrom<2>(a, first, factors, k0, columns);
  if (first < last) SubtractPanelFrom<1>(a, first, factors, k0, columns);
}

// Rows [k0, k1) := L^-1 rows.
PALPATE_INLINE void ForwardSubstitute(const RowMajor& a, int k0, int k1, const Factors& factors,
                                      const Columns& columns) noexcept {
  for (int j = columns.begin; j < columns.end; j += kLane8) {
    for (int k = k0 + 1; k < k1; ++k) {
      Values sum = Load(a.row(k) + j);
      for (int i = k0; i < k; ++i) sum -= factors.row(k)[i - k0] * Load(a.row(i) + j);
      Store(a.row(k) + j, sum);
    }
  }
}

// Rows [k0, k1) := U^-1 rows.
PALPATE_INLINE void BackSubstitute(const RowMajor& a, int k0, int k1, const Factors& factors,
                                   const Columns& columns) noexcept {
  for (int k = k1 - 1; k >= k0; --k) {
    const double inverse = factors.row(k)[k - k0];
    for (int j = columns.begin; j < columns.end; j += kLane8) {
      Values sum = Load(a.row(k) + j);
      for (int i = k + 1; i < k1; ++i) sum -= factors.row(k)[i - k0] * Load(a.row(i) + j);
      Store(a.row(k) + j, inverse * sum);
    }
  }
}

PALPATE_DISPATCHED bool FactoriseInPlace(const RowMajor& a, int order, double* multipliers,
                                         int* pivots) noexcept {
  double largest = 0;
  for (int k0 = 0; k0 < order; k0 += kPanel) {
    const int k1 = std::min(k0 + kPanel, order);
    if (!FactorizePanel(a, order, k0, k1, multipliers, pivots, &largest)) return false;
    const Factors factors{multipliers, kPanel};
    const Columns right{PaddedTo8(k1), PaddedTo8(order)};
    ForwardSubstitute(a, k0, k1, factors, right);
    SubtractPanel(a, k1, order, factors, k0, right);
    for (int i = k0 + 1; i < order; ++i) {
      std::copy_n(factors.row(i), std::min(i - k0, kPanel), a.row(i) + k0);
    }
  }
  return true;
}

PALPATE_DISPATCHED void SolveInPlace(const Factors& lu, int order, const int* pivots,
                                     const RowMajor& b) noexcept {
  const Columns all{0, b.stride};
  for (int k = 0; k < order; ++k) {
    if (pivots[k] != k) std::swap_ranges(b.row(k), b.row(k) + b.stride, b.row(pivots[k]));
  }
  for (int k0 = 0; k0 < order; k0 += kPanel) {
    const int k1 = std::min(k0 + kPanel, order);
    const Factors factors{lu.data + k0, lu.pitch};
    ForwardSubstitute(b, k0, k1, factors, all);
    SubtractPanel(b, k1, order, factors, k0, all);
  }
  for (int k1 = order; k1 > 0; k1 -= kPanel) {  // the incomplete panel has no rows above it
    const int k0 = std::max(k1 - kPanel, 0);
    const Factors factors{lu.data + k0, lu.pitch};
    BackSubstitute(b, k0, k1, factors, all);
    SubtractPanel(b, 0, k0, factors, k0, all);
  }
}

// Returns the next odd number of lanes, because rows with an even number would share few cache
// sets.
int OddLanes(int n) {
  return PaddedTo8(n) / kLane8 % 2 == 1 ? PaddedTo8(n) : PaddedTo8(n) + kLane8;
}

}  // namespace

void DenseFactor::Reset(int order) {
  order_ = order;
  stride_ = OddLanes(order);
  entries_.resize(static_cast<std::size_t>(order) * static_cast<std::size_t>(stride_));
  multipliers_.resize(static_cast<std::size_t>(order) * kPanel);
  pivots_.resize(static_cast<std::size_t>(order));
}

bool DenseFactor::Factorise() noexcept {
  return FactoriseInPlace({entries_.data(), stride_}, order_, multipliers_.data(), pivots_.data());
}

void DenseFactor::Solve(const RowMajor& b) const noexcept {
  SolveInPlace({entries_.data(), stride_}, order_, pivots_.data(), b);
}

}  // namespace palpate
