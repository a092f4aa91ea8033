// LU factorisation with partial pivoting of large dense matrices, one block of columns after the
// other, so that it can report progress and be stopped.
//
// It uses LAPACK and BLAS: a block of columns is updated with all columns to its left by one
// triangular solve and one product, then its panel is factorised (Golub and Van Loan, Matrix
// Computations (2013), 3.2.11 and 3.4).
#pragma once

#include <vector>

#include <Eigen/Core>

namespace palpate {

class DenseLu {
 public:
  static constexpr int kWidth = 256;  // columns of a block, the last one may have fewer

  // Takes ownership of the square matrix.
  explicit DenseLu(Eigen::MatrixXd A);

  [[nodiscard]] int order() const { return static_cast<int>(A_.cols()); }
  [[nodiscard]] int blocks() const { return (order() + kWidth - 1) / kWidth; }
  // Blocks that are factorised; solutions need all.
  [[nodiscard]] int done() const { return done_; }

  // The next block. Work grows linearly with its number. False: a pivot is zero, or the matrix is
  // not finite.
  bool FactorizeNext();

  // Replaces B by A^-1 B. Fastest with some hundred columns at once.
  void SolveInPlace(Eigen::Ref<Eigen::MatrixXd> B) const;
  // Estimate of 1 / (|A| |A^-1|) in the 1-norm (Higham 1988), mostly sharp and never too small.
  [[nodiscard]] double ReciprocalCondition() const;

 private:
  void SwapRows(int first_column, int columns, int begin, int end);
  void TakeUpLeft(int begin, int width);

  Eigen::MatrixXd A_;
  double norm_ = 0;           // of A, the largest column sum
  std::vector<int> swapped_;  // LAPACK's: row k + 1 was swapped with this one, counted from one
  int done_ = 0;
};

}  // namespace palpate
