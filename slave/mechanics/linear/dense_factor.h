// Factors of small dense matrices, without allocation once they were as large: with exchanges of
// rows for one system with its right-hand sides, without them for one or a few solutions.
#pragma once

#include "slave/mechanics/linear/dense_kernels.h"

namespace palpate {

// Triangular factors without exchanges, for one or a few solutions: a third of the work of the
// inverse, 0.2 to 0.5 of the time of LAPACK with OpenBLAS (bench_linear).
//
//   A = L W,   L_ik = A_ik - sum_q<k L_iq W_qk  (i >= k),   W_kj = L_kk^-1 (A_kj - sum_q<k L_kq
//   W_qj)
//
// in tiles of eight, W with unit tiles on its diagonal (Crout; Golub and Van Loan, Matrix
// Computations (2013), 3.2). Rows are not exchanged: for matrices whose symmetric part is positive
// definite, as compliances are; check the solution where that is not certain. Where the matrix is
// symmetric, L_ik is the transpose of L_kk W_ki, and half of the work is saved.
class DenseFactor {
 public:
  // Of a row-major matrix; of a symmetric one the lower triangle is not read. False: a pivot is not
  // above `least_pivot` times the entry it came from, or not finite. Memory only grows. O(n^3).
  bool Factorise(const double* a, int lda, int order, bool symmetric, double least_pivot);

  // x = A^-1 b; both PaddedTo8(order) long, b zero beyond the order. O(n^2).
  void Solve(const double* b, double* x) const noexcept;

  // Makes row_of_left() and row_of_right() ready: with them single entries of the inverse,
  //   (A^-1)_ij = sum over q >= from of left_iq right_jq,   left = W^-1, right = L^-T,
  // `from` the largest multiple of kLane8 that is at most i and j. O(n^3), as much as the factors.
  void InvertTriangles() {
    InvertLeft();
    InvertRight();
  }
  // Aligned, to be read up to size(). Kept beyond the last row: room for kLane8 more, whose numbers
  // mean nothing.
  [[nodiscard]] const double* row_of_left(int i) const { return left_.get() + Offset(i, 0); }
  [[nodiscard]] const double* row_of_right(int i) const { return right_.get() + Offset(i, 0); }
  [[nodiscard]] double InverseEntry(int i, int j) const noexcept;
  [[nodiscard]] int size() const { return PaddedTo8(order_); }
  [[nodiscard]] int stride() const { return stride_; }

  [[nodiscard]] std::size_t memory_bytes() const {
    return sizeof(double) * static_cast<std::size_t>(capacity_) *
           static_cast<std::size_t>(3 * stride_);
  }

 private:
  [[nodiscard]] long Offset(int i, int j) const { return static_cast<long>(i) * stride_ + j; }
  [[nodiscard]] double* Tile(int i, int j) const { return factors_.get() + Offset(i, j); }
  [[nodiscard]] double* InverseTile(int k) const {
    return inverses_.get() + static_cast<long>(k) * kLane8;
  }
  void Copy(const double* a, int lda);
  bool InvertTile(int k, const double* a, int lda, double least_pivot);
  void InvertLeft();
  void InvertRight();

  bool symmetric_ = false;
  int order_ = 0, capacity_ = 0, stride_ = 0;
  AlignedArray factors_;       // L and, above its diagonal, W: rows of stride_
  AlignedArray inverses_;      // of L's diagonal tiles, one after the other
  AlignedArray left_, right_;  // upper triangles; what is below the tiles of the diagonal is zero
  AlignedArray panel_;
};

constexpr int kPanel = kLane8;  // pivots that are eliminated together: a panel is one lane wide

// The next odd number of lanes: rows of even ones would share few places of the cache.
constexpr int OddLanes(int n) {
  return PaddedTo8(n) / kLane8 % 2 == 1 ? PaddedTo8(n) : PaddedTo8(n) + kLane8;
}

// Rows of `stride` doubles, a multiple of kLane8.
struct RowMajor {
  double* data = nullptr;
  int stride = 0;
  [[nodiscard]] double* row(int i) const { return data + static_cast<long>(i) * stride; }
};

// Solves A X = B in place for [A | B]: A has `order` columns, B begins at column PaddedTo8(order)
// and ends with the row; X replaces B, A is destroyed. What pads must be finite. Gaussian
// elimination with threshold partial pivoting, in panels; up to 200 unknowns in 0.3 to 0.7 of the
// time of LAPACK with OpenBLAS (bench_linear). False: a pivot is below 1e-13 of the largest one so
// far, or not finite. `scratch`: room for kPanel * order numbers.
bool SolveInPlace(const RowMajor& augmented, int order, double* scratch) noexcept;

}  // namespace palpate
