// LU factorisation with partial pivoting, one block of columns after the other: each finished block
// can be kept, so that a long factorisation may be stopped and taken up again.
//
// Left-looking (Golub and Van Loan, Matrix Computations, 3.2.11 and 3.4): a block of columns takes
// up all that lies left of it by one triangular solve and one product, then its own panel is
// factorised by halves. As fast as a right-looking one, and bit for bit the same however often it
// was interrupted.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace palpate {

class BlockLu {
 public:
  static constexpr int kWidth = 192;  // columns of a block, the last one may have fewer

  // Square, finite.
  explicit BlockLu(Eigen::MatrixXd A);

  [[nodiscard]] int order() const { return static_cast<int>(A_.cols()); }
  [[nodiscard]] int blocks() const { return (order() + kWidth - 1) / kWidth; }
  // Blocks that are factorised; solutions need all.
  [[nodiscard]] int done() const { return done_; }

  // The next block. Work grows linearly with its number. False: a pivot is zero.
  bool FactorizeNext();
  // What FactorizeNext left behind: the columns of block `k` = done() - 1 and its row swaps.
  [[nodiscard]] std::vector<double> LastBlock() const;
  // Takes LastBlock()'s answer of an earlier run in place of FactorizeNext(). False: does not fit.
  bool AdoptNext(const std::vector<double>& block);

  // B becomes A^-1 B.
  void SolveInPlace(Eigen::Ref<Eigen::MatrixXd> B) const;
  // Estimate of the condition number in the 1-norm (Hager 1984), a lower bound, mostly sharp.
  [[nodiscard]] double Condition() const;

 private:
  using Columns = Eigen::Ref<Eigen::MatrixXd>;
  void SwapRows(Columns columns, int begin, int end) const;
  void TakeUpLeft(Columns columns, int count) const;
  bool FactorizePanel(int begin, int end);
  bool FactorizeLeaf(int begin, int end);
  [[nodiscard]] Eigen::VectorXd SolveTransposed(Eigen::VectorXd b) const;

  Eigen::MatrixXd A_;
  double norm_ = 0;           // of A, the largest column sum
  std::vector<int> swapped_;  // row k was swapped with this one when column k was eliminated
  int done_ = 0;
};

}  // namespace palpate
