#include "slave/mechanics/linear/dense_factor.h"

#include <algorithm>
#include <array>
#include <cmath>

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
  for (int j = columns.begin; j < columns.end; j += kLane8) {
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
  for (; end > begin; end -= kLane8) {
    for (int k = k0; k < k1; ++k) {
      const double* row = a.row(k) + end - kLane8;
      for (int l = 0; l < kLane8; ++l) {
        if (row[l] != 0) return {begin, end};
      }
    }
  }
  return {begin, end};
}

// Rows [k0, k1) := L^-1 rows.
PALPATE_INLINE void ForwardSubstitute(const RowMajor& a, int k0, int k1, const double* multipliers,
                                      const Columns& columns) noexcept {
  for (int j = columns.begin; j < columns.end; j += kLane8) {
    for (int k = k0 + 1; k < k1; ++k) {
      Values sum = At(a.row(k) + j);
      for (int i = k0; i < k; ++i) sum -= multipliers[k * kPanel + i - k0] * At(a.row(i) + j);
      At(a.row(k) + j) = sum;
    }
  }
}

// B := U^-1 B in panels from the last row on; the one that is not full has no rows above it.
PALPATE_INLINE void BackSubstitute(const RowMajor& a, int order) noexcept {
  const int begin = PaddedTo8(order);
  for (int k1 = order; k1 > 0; k1 -= kPanel) {
    const int k0 = std::max(k1 - kPanel, 0);
    for (int k = k1 - 1; k >= k0; --k) {
      const double* factors = a.row(k);
      const double inverse = 1 / factors[k];
      for (int j = begin; j < a.stride; j += kLane8) {
        Values sum = At(a.row(k) + j);
        for (int i = k + 1; i < k1; ++i) sum -= factors[i] * At(a.row(i) + j);
        At(a.row(k) + j) = inverse * sum;
      }
    }
    SubtractPanel(a, 0, k0, a.data + k0, a.stride, k0, {begin, a.stride});
  }
}

}  // namespace

bool DenseFactor::Factorise(const double* a, int lda, int order, bool symmetric,
                            double least_pivot) {
  order_ = order;
  symmetric_ = symmetric;
  const int size = PaddedTo8(order);
  if (size > capacity_) {
    capacity_ = PaddedTo8(order + order / 4);
    stride_ = capacity_ | kLane8;  // an odd number of lanes: rows do not fall on the same cache set
    const auto area =
        static_cast<std::size_t>(capacity_ + kLane8) * static_cast<std::size_t>(stride_);
    for (auto* array : {&factors_, &left_, &right_}) *array = MakeAligned(area);
    inverses_ = MakeAligned(static_cast<std::size_t>(capacity_) * kLane8);
    panel_ = MakeAligned(static_cast<std::size_t>(stride_) * kLane8);
  }
  Copy(a, lda);
  for (int k = 0; k < size; k += kLane8) {
    const int next = k + kLane8;
    SubtractWide(Tile(k, k), Tile(k, 0), Tile(0, k), stride_, k, size - k);
    if (!InvertTile(k, a, lda, least_pivot)) return false;
    if (symmetric) {
      for (int i = next; i < size; i += kLane8) {
        Transpose8(Tile(k, i), stride_, Tile(i, k), stride_);
      }
    } else if (next < size) {
      SubtractTall(Tile(next, k), Tile(next, 0), Tile(0, k), stride_, k, size - next);
    }
    if (next < size) MultiplyLeft(InverseTile(k), Tile(k, next), stride_, size - next);
  }
  return true;
}

void DenseFactor::Copy(const double* a, int lda) {
  const int size = PaddedTo8(order_);
  for (int i = 0; i < size; ++i) {
    double* to = Tile(i, 0);
    const int first = symmetric_ ? i / kLane8 * kLane8 : 0;
    const int last = i < order_ ? order_ : first;
    std::copy(a + static_cast<long>(i) * lda + first, a + static_cast<long>(i) * lda + last,
              to + first);
    std::fill(to + last, to + size, 0.0);
    if (i >= order_) to[i] = 1;
  }
}

bool DenseFactor::InvertTile(int k, const double* a, int lda, double least_pivot) {
  double* inverse = InverseTile(k);
  std::array<double, kLane8> least{};
  for (int r = 0; r < kLane8; ++r) {
    std::copy_n(Tile(k + r, k), kLane8, inverse + static_cast<long>(r) * kLane8);
    if (k + r >= order_) continue;
    double& bound = least[static_cast<std::size_t>(r)];
    bound = least_pivot * a[static_cast<long>(k + r) * (lda + 1)];
    if (!(bound >= 0 && std::isfinite(bound))) return false;
  }
  return Invert8(inverse, least.data());
}

// V = W^-1 from the last row on: V_k = I_k - W_k,>k V_>k.
void DenseFactor::InvertLeft() {
  const int size = this->size();
  for (int k = size - kLane8; k >= 0; k -= kLane8) {
    double* rows = left_.get() + Offset(k, k);
    for (int r = 0; r < kLane8; ++r) {
      std::fill_n(rows + Offset(r, 0), size - k, 0.0);
      rows[Offset(r, r)] = 1;
    }
    const int next = k + kLane8;
    if (next == size) continue;
    SubtractByUpper(rows + kLane8, Tile(k, next), left_.get() + Offset(next, next), stride_,
                    size - next);
  }
}

// The same for L^T, whose tiles on the diagonal are not unit ones; where the matrix is symmetric,
// L^T = D W, D those tiles.
void DenseFactor::InvertRight() {
  const int size = this->size();
  if (symmetric_) {
    for (int k = 0; k < size; k += kLane8) {
      MultiplyRight(left_.get() + k, InverseTile(k), right_.get() + k, stride_, k + kLane8);
    }
    return;
  }
  alignas(64) std::array<double, kLane8 * kLane8> transposed;
  for (int k = size - kLane8; k >= 0; k -= kLane8) {
    const int next = k + kLane8;
    double* rows = right_.get() + Offset(k, k);
    for (int r = 0; r < kLane8; ++r) std::fill_n(rows + Offset(r, 0), size - k, 0.0);
    Transpose8(InverseTile(k), kLane8, transposed.data(), kLane8);
    for (int i = next; i < size; i += kLane8) {
      Transpose8(Tile(i, k), stride_, panel_.get() + i, stride_);
    }
    if (next < size) {
      SubtractByUpper(rows + kLane8, panel_.get() + next, right_.get() + Offset(next, next),
                      stride_, size - next);
      MultiplyLeft(transposed.data(), rows + kLane8, stride_, size - next);
    }
    for (int r = 0; r < kLane8; ++r) {
      std::copy_n(transposed.data() + static_cast<long>(r) * kLane8, kLane8, rows + Offset(r, 0));
    }
  }
}

double DenseFactor::InverseEntry(int i, int j) const noexcept {
  std::array<double, 4> sums{};
  for (int q = std::max(i, j) / kLane8 * kLane8; q < size(); q += 4) {
    for (int l = 0; l < 4; ++l) {
      sums[static_cast<std::size_t>(l)] += row_of_left(i)[q + l] * row_of_right(j)[q + l];
    }
  }
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

void DenseFactor::Solve(const double* b, double* x) const noexcept {
  const int size = PaddedTo8(order_);
  alignas(64) std::array<double, kLane8> sums;
  for (int k = 0; k < size; k += kLane8) {
    EightDots(Tile(k, 0), stride_, x, k, sums.data());
    for (int r = 0; r < kLane8; ++r) {
      double& sum = sums[static_cast<std::size_t>(r)];
      sum = b[k + r] - sum;
    }
    EightDots(InverseTile(k), kLane8, sums.data(), kLane8, x + k);
  }
  for (int k = size - 2 * kLane8; k >= 0; k -= kLane8) {
    const int next = k + kLane8;
    EightDots(Tile(k, next), stride_, x + next, size - next, sums.data());
    for (int r = 0; r < kLane8; ++r) x[k + r] -= sums[static_cast<std::size_t>(r)];
  }
}

PALPATE_DISPATCHED bool SolveInPlace(const RowMajor& a, int order, double* scratch) noexcept {
  double largest = 0;
  for (int k0 = 0; k0 < order; k0 += kPanel) {
    const int k1 = std::min(k0 + kPanel, order);
    if (!FactorizePanel(a, order, k0, k1, scratch, &largest)) return false;
    const Columns columns = NonzeroColumns(a, k0, k1, PaddedTo8(k1));
    ForwardSubstitute(a, k0, k1, scratch, columns);
    SubtractPanel(a, k1, order, scratch + k1 * kPanel, kPanel, k0, columns);
  }
  BackSubstitute(a, order);
  return true;
}

}  // namespace palpate
