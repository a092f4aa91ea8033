// LU factorisation with partial pivoting of small dense systems: no allocation, no overhead below
// ten microseconds; Eigen's blocked one wins from some hundred unknowns on.
#pragma once

#include <vector>

namespace palpate {

// Rows of `stride` doubles, a multiple of kLane, so that every row is whole vectors.
struct RowMajor {
  double* data = nullptr;
  int rows = 0;
  int columns = 0;
  int stride = 0;
  [[nodiscard]] double* row(int i) const { return data + static_cast<long>(i) * stride; }
};

constexpr int kLane = 4;
constexpr int PaddedTo(int lane, int n) {
  return (n + lane - 1) / lane * lane;
}

// Solves A X = B in place for [A | B], B being the columns from A's order on, padding included:
// X replaces B, A is destroyed. Padding must be finite. Gaussian elimination with partial pivoting,
// blocks of eight pivots. False: a pivot is below 1e-13 of the largest entry of A, or not finite.
bool SolveInPlace(const RowMajor& augmented, int order) noexcept;

}  // namespace palpate
