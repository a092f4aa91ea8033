// LU factorisation with threshold pivoting of small dense systems, without allocation. Ours since
// up to 200 unknowns it takes 0.3 to 0.7 of the time of LAPACK with OpenBLAS (bench_linear).
#pragma once

#include <vector>

namespace palpate {

constexpr int kLane = 8;       // doubles that are worked on together
constexpr int kPanel = kLane;  // pivots that are eliminated together: a panel is one lane wide
constexpr int PaddedTo(int lane, int n) {
  return (n + lane - 1) / lane * lane;
}

// The next odd number of lanes: rows of even ones would share few places of the cache.
constexpr int OddLanes(int n) {
  return PaddedTo(kLane, n) / kLane % 2 == 1 ? PaddedTo(kLane, n) : PaddedTo(kLane, n) + kLane;
}

// Rows of `stride` doubles, a multiple of kLane.
struct RowMajor {
  double* data = nullptr;
  int stride = 0;
  [[nodiscard]] double* row(int i) const { return data + static_cast<long>(i) * stride; }
};

// Solves A X = B in place for [A | B]: A has `order` columns, B begins at column PaddedTo(kLane,
// order) and ends with the row; X replaces B, A is destroyed. What pads must be finite. Gaussian
// elimination with threshold partial pivoting, in panels. False: a pivot is below 1e-13 of the
// largest one so far, or not finite. `scratch`: room for kPanel * order numbers.
bool SolveInPlace(const RowMajor& augmented, int order, double* scratch) noexcept;

}  // namespace palpate
