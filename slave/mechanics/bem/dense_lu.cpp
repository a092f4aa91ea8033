#include "slave/mechanics/bem/dense_lu.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>

namespace palpate {
namespace {

constexpr double kSmallestPivot = 1e-13;  // of the largest entry

using Lane = Eigen::Map<Eigen::Array<double, kLane, 1>>;

// target -= sum over k of factors[k] * row k, columns [begin, end), whole lanes. The rows lie
// `stride` apart.
template <int kRows>
void SubtractRows(double* target, const double* factors, double* first, long stride, int begin,
                  int end) noexcept {
  for (int j = begin; j < end; j += kLane) {
    Eigen::Array<double, kLane, 1> sum = Lane(target + j);
    for (int k = 0; k < kRows; ++k) sum -= factors[k] * Lane(first + k * stride + j);
    Lane(target + j) = sum;
  }
}

using Column = Eigen::Map<Eigen::ArrayXd>;

// A panel's columns one after the other, so that the elimination runs along them.
struct Panel {
  double* data;
  int rows;
  [[nodiscard]] double* column(int j) const { return data + static_cast<long>(j) * rows; }
};

// The diagonal entry while it is at least a tenth of the largest one below it, else that one:
// compliances keep their diagonal, and nothing is searched or swapped.
int ChoosePivot(const double* column, int k, int rows) noexcept {
  const double largest = Eigen::Map<const Eigen::ArrayXd>(column + k, rows - k).abs().maxCoeff();
  if (std::abs(column[k]) >= 0.1 * largest) return k;
  int row = k;
  while (row < rows - 1 && std::abs(column[row]) != largest) ++row;
  return row;
}

// Eliminates the columns [k0, k1) in all rows from k0 on; later columns only follow the row swaps.
// `largest`: the largest pivot so far.
bool FactorizePanel(const RowMajor& a, int order, int k0, int k1, double* scratch,
                    double* largest) noexcept {
  const Panel panel{scratch, order - k0};
  for (int i = 0; i < panel.rows; ++i) {
    for (int j = 0; j < k1 - k0; ++j) panel.column(j)[i] = a.row(k0 + i)[k0 + j];
  }
  for (int k = 0; k < k1 - k0; ++k) {
    double* column = panel.column(k);
    const int pivot = ChoosePivot(column, k, panel.rows);
    const double entry = std::abs(column[pivot]);
    *largest = std::max(*largest, entry);
    if (!(entry > kSmallestPivot * *largest && std::isfinite(entry))) return false;
    if (pivot != k) {
      for (int j = 0; j < k1 - k0; ++j) std::swap(panel.column(j)[k], panel.column(j)[pivot]);
      std::swap_ranges(a.row(k0 + k) + k1, a.row(k0 + k) + a.stride, a.row(k0 + pivot) + k1);
    }
    const int below = panel.rows - k - 1;
    Column multipliers(column + k + 1, below);
    multipliers *= 1 / column[k];
    for (int j = k + 1; j < k1 - k0; ++j) {
      Column(panel.column(j) + k + 1, below) -= panel.column(j)[k] * multipliers;
    }
  }
  for (int i = 0; i < panel.rows; ++i) {
    for (int j = 0; j < k1 - k0; ++j) a.row(k0 + i)[k0 + j] = panel.column(j)[i];
  }
  return true;
}

// Subtracts from row `i`, columns from `begin` on, the rows [k, last) times its entries there.
void SubtractAll(const RowMajor& a, int i, int k, int last, int begin) noexcept {
  for (; k + 4 <= last; k += 4) {
    SubtractRows<4>(a.row(i), a.row(i) + k, a.row(k), a.stride, begin, a.stride);
  }
  switch (last - k) {
    case 3:
      return SubtractRows<3>(a.row(i), a.row(i) + k, a.row(k), a.stride, begin, a.stride);
    case 2:
      return SubtractRows<2>(a.row(i), a.row(i) + k, a.row(k), a.stride, begin, a.stride);
    case 1:
      return SubtractRows<1>(a.row(i), a.row(i) + k, a.row(k), a.stride, begin, a.stride);
    default:
      return;
  }
}

// B := U^-1 B.
void BackSubstitute(const RowMajor& a, int order) noexcept {
  for (int k = order - 1; k >= 0; --k) {
    SubtractAll(a, k, k + 1, order, PaddedTo(kLane, order));
    double* row = a.row(k);
    const double inverse = 1 / row[k];
    for (int j = PaddedTo(kLane, order); j < a.stride; j += kLane) Lane(row + j) *= inverse;
  }
}

}  // namespace

bool SolveInPlace(const RowMajor& a, int order, double* scratch) noexcept {
  double largest = 0;
  for (int k0 = 0; k0 < order; k0 += kPanel) {
    const int k1 = std::min(k0 + kPanel, order);
    if (!FactorizePanel(a, order, k0, k1, scratch, &largest)) return false;
    const int begin = PaddedTo(kLane, k1);
    for (int k = k0 + 1; k < k1; ++k) SubtractAll(a, k, k0, k, begin);
    for (int i = k1; i < order; ++i) SubtractAll(a, i, k0, k1, begin);
  }
  BackSubstitute(a, order);
  return true;
}

}  // namespace palpate
