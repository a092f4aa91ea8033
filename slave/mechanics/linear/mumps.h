// MUMPS for sparse symmetric matrices: a factor of positive definite ones, and the order of
// elimination that keeps factors sparse.
//
// Its module variables are the process's: of all that is below, one call runs at a time, the others
// wait for it.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/SparseCore>

namespace palpate {

struct Mumps;

// Move-only; one object must not be used by two threads.
class SpdFactor {
 public:
  // The lower triangle of the matrix. Throws std::invalid_argument: not positive definite;
  // std::bad_alloc; std::runtime_error: the solver failed for another reason, by its number.
  explicit SpdFactor(const Eigen::SparseMatrix<double>& lower);
  ~SpdFactor();
  SpdFactor(SpdFactor&&) noexcept;
  SpdFactor& operator=(SpdFactor&&) noexcept;

  // Solves in place for `count` right-hand sides, column by column. The digits of one depend on how
  // many are solved together.
  void Solve(double* columns, int count);

  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  std::unique_ptr<Mumps> mumps_;
};

// Nodes of a graph (neighbours of every node, itself included), first to be eliminated first: by
// minimum fill, large ones by PORD's mixture of it with nested dissection (Schulze 2001). The same
// for the same graph. Throws std::bad_alloc, std::runtime_error as above.
std::vector<int> EliminationOrder(const std::vector<std::vector<int>>& neighbours);

}  // namespace palpate
