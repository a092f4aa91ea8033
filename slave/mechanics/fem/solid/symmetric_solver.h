// Solves with a sparse symmetric matrix whose pattern never changes: by L D L^T while the factor
// stays small, else by conjugate gradients with an incomplete factor.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include <Eigen/Core>

#include "slave/mechanics/fem/solid/block_layout.h"
#include "slave/mechanics/linear/sparse_ldlt.h"

namespace palpate {

class SymmetricSolver {
 public:
  struct Limits {
    std::size_t factor_bytes = std::size_t{2} << 30U;
    double factor_flops = 2e11;  // some tens of seconds
  };
  // Analyses the pattern (upper triangle, ordered to be sparse). O(entries of the factor).
  SymmetricSolver(const SparseMatrix& pattern, const Limits& limits);
  ~SymmetricSolver();

  // False: a zero pivot, with `definite` a negative one, or (iterative) a negative diagonal.
  bool Factorize(const SparseMatrix& matrix, bool definite = false);
  // x becomes A^-1 b. The matrix is that of Factorize, still unchanged. Iterations go on until the
  // true residual falls below `tolerance` of b. False: it did not.
  bool Solve(const Eigen::VectorXd& b, double tolerance, Eigen::VectorXd* x);

  [[nodiscard]] bool is_direct() const { return direct_; }
  // Negative pivots of the last factor; -1: not known (iterative).
  [[nodiscard]] int negative_pivots() const { return negative_pivots_; }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_; }
  [[nodiscard]] double factor_flops() const { return factor_flops_; }
  [[nodiscard]] int iterations() const { return iterations_; }  // of the last Solve; 0: direct

 private:
  struct Iterative;
  bool direct_ = true;
  int negative_pivots_ = -1, iterations_ = 0;
  std::size_t memory_bytes_ = 0;
  double factor_flops_ = 0;
  std::unique_ptr<SparseLdlt> factor_;
  std::unique_ptr<Iterative> iterative_;
};

}  // namespace palpate
