#include "slave/mechanics/bem/dense_lu.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kSmallestPivot = 1e-13;  // of the largest entry
constexpr int kPanel = 8;

// target -= sum over k of factors[k] * rows[k], columns [begin, end).
template <int kRows>
void SubtractRows(double* __restrict target, const double* factors, const double* first, int stride,
                  int begin, int end) noexcept {
  double l[kRows];
  for (int k = 0; k < kRows; ++k) l[k] = factors[k];
#pragma GCC ivdep
  for (int j = begin; j < end; ++j) {
    double sum = target[j];
#pragma GCC unroll 8
    for (int k = 0; k < kRows; ++k) sum -= l[k] * first[k * stride + j];
    target[j] = sum;
  }
}

double LargestEntry(const RowMajor& a, int order) noexcept {
  double largest = 0;
  for (int i = 0; i < order; ++i) {
    for (int j = 0; j < order; ++j) largest = std::max(largest, std::abs(a.row(i)[j]));
  }
  return largest;
}

// Eliminates the columns [k0, k1) in all rows from k0 on; other columns only follow the row swaps.
bool FactorizePanel(const RowMajor& a, int order, int k0, int k1, double smallest) noexcept {
  for (int k = k0; k < k1; ++k) {
    int pivot = k;
    for (int i = k + 1; i < order; ++i) {
      if (std::abs(a.row(i)[k]) > std::abs(a.row(pivot)[k])) pivot = i;
    }
    if (!(std::abs(a.row(pivot)[k]) > smallest)) return false;
    if (pivot != k) std::swap_ranges(a.row(k) + k0, a.row(k) + a.stride, a.row(pivot) + k0);
    const double* pivot_row = a.row(k);
    const double inverse = 1 / pivot_row[k];
    for (int i = k + 1; i < order; ++i) {
      double* row = a.row(i);
      const double l = row[k] *= inverse;
      for (int j = k + 1; j < k1; ++j) row[j] -= l * pivot_row[j];
    }
  }
  return true;
}

// B := U^-1 B, blocks of columns that stay in the first cache.
void BackSubstitute(const RowMajor& a, int order) noexcept {
  const int begin = order;
  for (int k = order - 1; k >= 0; --k) {
    double* row = a.row(k);
    const double inverse = 1 / row[k];
    for (int j = begin; j < a.stride; ++j) row[j] *= inverse;
    for (int i = 0; i < k; ++i) {
      double* target = a.row(i);
      const double u = target[k];
#pragma GCC ivdep
      for (int j = begin; j < a.stride; ++j) target[j] -= u * row[j];
    }
  }
}

}  // namespace

bool SolveInPlace(const RowMajor& a, int order) noexcept {
  const double smallest = kSmallestPivot * LargestEntry(a, order);
  if (!std::isfinite(smallest)) return false;
  for (int k0 = 0; k0 < order; k0 += kPanel) {
    const int k1 = std::min(k0 + kPanel, order);
    if (!FactorizePanel(a, order, k0, k1, smallest)) return false;
    for (int k = k0 + 1; k < k1; ++k) {
      for (int p = k0; p < k; ++p) {
        SubtractRows<1>(a.row(k), a.row(k) + p, a.row(p), a.stride, k1, a.stride);
      }
    }
    if (k1 - k0 < kPanel) break;
    for (int i = k1; i < order; ++i) {
      SubtractRows<kPanel>(a.row(i), a.row(i) + k0, a.row(k0), a.stride, k1, a.stride);
    }
  }
  BackSubstitute(a, order);
  return true;
}

}  // namespace palpate
