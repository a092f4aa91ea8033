// The inverse of a matrix that grows and shrinks by blocks of rows and columns: contacts that come
// and go one at a time.
//
//   [X_0 + U S^-1 V, -U S^-1; -S^-1 V, S^-1],  U = X_0 B, V = R X_0, S = D - R X_0 B
//
// is the inverse of [C_0 B; R D], X_0 that of C_0; and the inverse without the block k is
// X_rr - X_rk X_kk^-1 X_kr. Source: Golub and Van Loan, Matrix Computations (2013), 2.1.4. O(n^2).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/dense_factor.h"
#include "slave/mechanics/linear/small_lu.h"

namespace palpate {

// Blocks of one size, 1 to 6. Memory only grows. The matrix itself is kept beside its inverse: to
// see how far updates have drifted, and to start anew. Not finite or singular: false, and empty.
class BlockInverse {
 public:
  static constexpr int kLargestBlock = 6;

  // Without blocks, ready for `block` rows each.
  void Clear(int block);
  // Room for so many blocks: nothing allocates below it.
  void Reserve(int blocks);

  [[nodiscard]] int blocks() const { return blocks_; }
  [[nodiscard]] int order() const { return blocks_ * block_; }

  // Room for one more block: the caller writes the matrix's new rows and columns, [order(), order()
  // + block), then calls Append, or Extend as often as it likes and then Invert or Factorise.
  [[nodiscard]] double* matrix_row(int i) { return matrix_.data() + Offset(i); }
  // Only where inverted().
  [[nodiscard]] const double* inverse_row(int i) const { return inverse_.data() + Offset(i); }
  bool Append();
  void Extend() { ++blocks_; }
  bool Invert();
  // A quarter of the work of Invert: triangular factors, or the inverse where those do not do.
  // Nothing can be appended or removed then.
  bool Factorise();
  [[nodiscard]] bool inverted() const { return inverted_; }
  // The last block takes the place of block `k`.
  bool Remove(int k);

  // |C X v - v| / |v| for a fixed v without structure, largest components. O(n^2).
  [[nodiscard]] double Drift();

  // Of the inverse. The first call after Factorise costs O(n^3).
  [[nodiscard]] double Entry(int i, int j);

  // y := X x; both PaddedTo(kLane, order()) long, x zero beyond order().
  void Multiply(const double* x, double* y) const noexcept;

 private:
  [[nodiscard]] std::size_t Offset(int i) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(stride_);
  }
  void MoveLastBlock(std::vector<double>* matrix, int to) const;

  int block_ = 1, blocks_ = 0, capacity_ = 0;
  int stride_ = 0;  // of a row, whole lanes
  // Rows of `stride_`; entries beyond order() that share a lane with the matrix are zero.
  std::vector<double> matrix_, inverse_;
  std::vector<double> columns_, rows_, factors_;  // B^T, V: a row per column of a block; U
  std::vector<double> augmented_, scratch_;       // to invert
  bool inverted_ = true, entries_known_ = false;
  DenseFactor factor_;  // where not inverted
};

}  // namespace palpate
