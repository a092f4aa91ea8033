// Factor of a sparse symmetric positive definite matrix, by MUMPS: nested dissection and
// supernodes.
#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>

#include <Eigen/SparseCore>

namespace palpate {

// Move-only; not thread-safe.
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
  struct Mumps;
  std::unique_ptr<Mumps> mumps_;
};

}  // namespace palpate
