// The inverse of a small dense matrix whose unknowns come and go.
//
// A fresh inverse by symmetric sweeps in panels of eight (Beaton 1964; Goodnight 1979); unknowns
// are taken out and put in by bordering, O(m^2) each:
//
//   out: P - P_k (P_kk)^-1 P_k^T      in: V = P c,  s = (d - c^T V)^-1,  [P + V s V^T, -V s; ., s]
//
// For matrices whose symmetric part is positive definite, as compliances are. After every change a
// probe vector is sent through the matrix and back; where it does not return, the inverse is taken
// afresh. Where all unknowns changed and few answers are wanted, triangular factors do in its
// place.
#pragma once

#include "slave/mechanics/linear/dense_factor.h"
#include "slave/mechanics/linear/dense_kernels.h"

namespace palpate {

class UpdatedInverse {
 public:
  // Symmetric matrices are read in their lower triangle only.
  explicit UpdatedInverse(bool symmetric) : symmetric_(symmetric) {}

  // Starts again: the matrix is to be filled by row(), then Invert() or Factorise(). Memory only
  // grows.
  void Reset(int order);
  // False: singular, nearly so, or not finite; the state is then that after Reset.
  bool Invert();
  // A good half of the work of Invert(): Solve() and InverseBlock() answer by triangular factors.
  // Where those are not good enough the inverse is taken. False: as Invert().
  bool Factorise();
  // The inverse itself is there: needed to Splice().
  [[nodiscard]] bool inverted() const { return inverted_; }

  // Takes out `removed` unknowns at `first` and makes room for `inserted` there: fill their rows
  // (not symmetric: and columns), then Border() them. False: no room, or drifted; start again.
  bool Splice(int first, int removed, int inserted);
  // Several spliced ranges are bordered one after the other.
  bool Border(int first, int count);
  // After the last Border: true where the probe returned, or a fresh inverse was good.
  bool Settle();

  // x = inverse times b; both aligned with room for padded() numbers, b ends in zeros.
  void Solve(const double* b, double* x) const noexcept {
    if (inverted_) {
      RowDot(inverse_.get(), stride_, b, padded(), x);
    } else {
      factor_.Solve(b, x);
    }
  }
  // Before Entry() and InverseBlock(); O(m^3) the first time after Factorise(), else nothing to do.
  void PrepareBlocks() {
    if (!inverted_ && !blocks_ready_) factor_.InvertTriangles();
    blocks_ready_ = true;
  }
  [[nodiscard]] double Entry(int row, int column) const noexcept {
    return inverted_ ? inverse_row(row)[column] : factor_.InverseEntry(row, column);
  }
  // The 3 x 3 block of the inverse that begins at these unknowns, row-major; what overhangs the
  // order means nothing.
  void InverseBlock(int row, int column, double* block) const noexcept;

  [[nodiscard]] int order() const { return order_; }
  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] int padded() const { return PaddedTo8(order_); }
  [[nodiscard]] double* row(int i) { return matrix_.get() + static_cast<long>(i) * stride_; }
  [[nodiscard]] const double* row(int i) const {
    return matrix_.get() + static_cast<long>(i) * stride_;
  }
  // Only where inverted().
  [[nodiscard]] const double* inverse_row(int i) const {
    return inverse_.get() + static_cast<long>(i) * stride_;
  }
  [[nodiscard]] std::size_t memory_bytes() const;
  // Fresh inverses so far: what updates save.
  [[nodiscard]] long inversions() const { return inversions_; }

 private:
  double* InverseRow(int i) { return inverse_.get() + static_cast<long>(i) * stride_; }
  void Complete();
  bool InvertUpTo3();
  bool InvertBySweeps();
  bool InvertByPivoting();
  bool Sweep(int panel);
  void TakeOut(int first, int count);
  bool BorderPanel(int at, int size);
  void FillBorder(int at, int size);
  void ClearInverse(int first, int count);
  [[nodiscard]] double ProbeError();

  bool symmetric_;
  bool inverted_ = false, blocks_ready_ = false;
  DenseFactor factor_;  // where not inverted
  long inversions_ = 0;
  int order_ = 0;
  int capacity_ = 0;  // padded
  int stride_ = 0;
  AlignedArray matrix_, inverse_;  // rows of stride_; what pads the inverse is zero
  AlignedArray panel_, panel_by_pivot_, rows_;
  AlignedArray probe_, image_, returned_;
};

}  // namespace palpate
