// DenseLu (slave/mechanics/linear/dense_lu.h) of a matrix that no rank has as a whole: the same
// blocks of columns, by ScaLAPACK. Blocks that one of both has kept the other can take up.
#pragma once

#include <vector>

#include "slave/precompute/distributed_matrix.h"

namespace palpate {

// All but the accessors is called by every rank.
class DistributedLu {
 public:
  static constexpr int kBlock = 64;  // rows and columns of a block of the distribution

  // `grid`: of all ranks. Square, in blocks of kBlock. Takes the matrix over.
  DistributedLu(const Ranks& ranks, const ProcessGrid& grid, DistributedMatrix A);

  [[nodiscard]] int order() const { return A_.rows(); }
  [[nodiscard]] int blocks() const;
  [[nodiscard]] int done() const { return done_; }

  // False: a pivot is zero.
  bool FactorizeNext();
  // As of DenseLu; on the first rank, empty on others.
  std::vector<double> LastBlock();
  // Of the first rank, whose `block` counts.
  bool AdoptNext(const std::vector<double>& block);

  // B becomes A^-1 B. In blocks of kBlock.
  void SolveInPlace(DistributedMatrix* B) const;
  [[nodiscard]] double ReciprocalCondition() const;

 private:
  [[nodiscard]] int WidthOf(int block) const;
  void SwapRows(int first_column, int columns, int begin, int count);
  void TakeUpLeft(int begin, int width);
  void SetPivots(int begin, const std::vector<double>& rows);

  const Ranks& ranks_;
  const ProcessGrid& grid_;
  ProcessGrid alone_;  // the first rank
  DistributedMatrix A_;
  double norm_ = 0;
  std::vector<int> pivots_;  // ScaLAPACK's, of the rows of this rank
  int done_ = 0;
};

}  // namespace palpate
