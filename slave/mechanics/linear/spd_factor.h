// A factor of a sparse symmetric positive definite matrix whose rows are in any order.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/SparseCore>

#include "slave/mechanics/linear/sparse_ldlt.h"

namespace palpate {

// One object must not be used by two threads.
class SpdFactor {
 public:
  // The lower triangle of the matrix. Throws std::invalid_argument: not positive definite;
  // std::bad_alloc.
  explicit SpdFactor(const Eigen::SparseMatrix<double>& lower);

  // Solves in place for `count` right-hand sides, column by column. The rounding of a column
  // depends on `count`.
  void Solve(double* columns, int count);

  [[nodiscard]] std::size_t memory_bytes() const { return factor_->memory_bytes(); }

 private:
  std::vector<int> order_;  // rows, first to be eliminated first
  std::optional<SparseLdlt<double>> factor_;
};

}  // namespace palpate
