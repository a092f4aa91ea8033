// LU factors of small dense matrices with exchanges of rows, without allocation for sizes that
// occurred before. A model's update has tens of unknowns.
#pragma once

#include <vector>

namespace palpate {

constexpr int kLane8 = 8;
constexpr int PaddedTo8(int n) {
  return (n + kLane8 - 1) / kLane8 * kLane8;
}

// Rows of `stride` doubles, a multiple of kLane8.
struct RowMajor {
  double* data = nullptr;
  int stride = 0;
  [[nodiscard]] double* row(int i) const { return data + static_cast<long>(i) * stride; }
};

// Gaussian elimination with threshold partial pivoting, in panels of eight columns (Golub and Van
// Loan, Matrix Computations (2013), 3.2 and 3.4); factors and one solution take 0.3 to 0.7 of the
// time of LAPACK with OpenBLAS up to 200 unknowns (bench_linear).
class DenseFactor {
 public:
  // Prepares memory for a matrix of this order, to be filled with row(). Memory only grows.
  void Reset(int order);
  [[nodiscard]] double* row(int i) { return RowMajor{entries_.data(), stride_}.row(i); }
  [[nodiscard]] int order() const { return order_; }
  [[nodiscard]] int stride() const { return stride_; }

  // Factorises in place, O(n^3). Returns false if a pivot is below 1e-13 of the largest one so far,
  // or not finite.
  bool Factorise() noexcept;
  // The rows of `b` become those of A^-1 b, all of its columns; O(n^2) for each eight of them.
  void Solve(const RowMajor& b) const noexcept;

 private:
  int order_ = 0, stride_ = 0;
  std::vector<double> entries_;  // L below the diagonal, U above it, inverse pivots on it
  std::vector<double> multipliers_;
  std::vector<int> pivots_;  // for each row the row that was exchanged with it
};

}  // namespace palpate
