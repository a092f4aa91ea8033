// MUMPS for sparse symmetric positive definite matrices.
//
// Its module variables are the process's: of all that is below, one call runs at a time, the others
// wait for it.
#pragma once

#include <memory>

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

}  // namespace palpate
