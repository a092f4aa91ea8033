#include "slave/mechanics/bem/pivoted_lu.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kNarrow = 16;          // columns that are factorised one by one
constexpr Index kColumnsAtOnce = 256;  // of right-hand sides

}  // namespace

PivotedLu::PivotedLu(MatrixXd* A, const Stage& stage)
    : A_(*A),
      norm_(A->cwiseAbs().colwise().sum().maxCoeff()),
      pivot_(static_cast<std::size_t>(A->cols())) {
  Factorise(0, A_.cols(), stage);
}

// The columns [first, first + count) from row `first` on; rows are swapped in these columns only.
void PivotedLu::Factorise(Index first, Index count, const Stage& stage) {
  if (count <= kNarrow) {
    const double left = 1 - static_cast<double>(first) / static_cast<double>(A_.cols());
    stage.Report(1 - left * left * left);
    FactoriseNarrow(first, count);
    return;
  }
  const Index half = std::max(kNarrow, count / (2 * kNarrow) * kNarrow);
  const Index second = first + half;
  const Index rest = count - half;
  const Index below = A_.rows() - second;
  Factorise(first, half, stage);
  SwapRows(first, second, A_.middleCols(second, rest));
  A_.block(first, first, half, half)
      .triangularView<Eigen::UnitLower>()
      .solveInPlace(A_.block(first, second, half, rest));
  A_.block(second, second, below, rest).noalias() -=
      A_.block(second, first, below, half) * A_.block(first, second, half, rest);
  Factorise(second, rest, stage);
  SwapRows(second, second + rest, A_.middleCols(first, half));
}

void PivotedLu::FactoriseNarrow(Index first, Index count) {
  for (Index k = first; k < first + count; ++k) {
    const Index below = A_.rows() - k - 1;
    Index largest = 0;
    A_.col(k).tail(below + 1).cwiseAbs().maxCoeff(&largest);
    pivot_[static_cast<std::size_t>(k)] = k + largest;
    if (largest > 0) {
      A_.row(k).segment(first, count).swap(A_.row(k + largest).segment(first, count));
    }
    const double pivot = A_(k, k);
    if (pivot == 0) continue;  // singular; the condition says so
    A_.col(k).tail(below) /= pivot;
    for (Index j = k + 1; j < first + count; ++j) {
      A_.col(j).tail(below) -= A_(k, j) * A_.col(k).tail(below);
    }
  }
}

void PivotedLu::SwapRows(Index first, Index last, Eigen::Ref<MatrixXd> columns) const {
  for (Index j = 0; j < columns.cols(); ++j) {
    for (Index k = first; k < last; ++k) {
      std::swap(columns(k, j), columns(pivot_[static_cast<std::size_t>(k)], j));
    }
  }
}

void PivotedLu::Solve(MatrixXd* B, const Stage& stage) const {
  for (Index j = 0; j < B->cols(); j += kColumnsAtOnce) {
    stage.Report(static_cast<double>(j) / static_cast<double>(B->cols()));
    auto columns = B->middleCols(j, std::min(kColumnsAtOnce, B->cols() - j));
    SwapRows(0, A_.rows(), columns);
    A_.triangularView<Eigen::UnitLower>().solveInPlace(columns);
    A_.triangularView<Eigen::Upper>().solveInPlace(columns);
  }
}

// Maximises |A^-1 x| over |x| = 1 by steps along the gradient; five are more than are ever needed.
double PivotedLu::ReciprocalCondition() const {
  const Index n = A_.cols();
  if (A_.diagonal().cwiseAbs().minCoeff() == 0 || !A_.allFinite()) return 0;
  VectorXd x = VectorXd::Constant(n, 1 / static_cast<double>(n));
  double inverse_norm = 0;
  for (int step = 0; step < 5; ++step) {
    SwapRows(0, n, x);
    A_.triangularView<Eigen::UnitLower>().solveInPlace(x);
    A_.triangularView<Eigen::Upper>().solveInPlace(x);
    const double norm = x.lpNorm<1>();
    if (!(norm > inverse_norm)) break;
    inverse_norm = norm;
    x = x.unaryExpr([](double value) { return value < 0 ? -1.0 : 1.0; });
    A_.triangularView<Eigen::Upper>().transpose().solveInPlace(x);
    A_.triangularView<Eigen::UnitLower>().transpose().solveInPlace(x);
    for (Index k = n; k-- > 0;) std::swap(x[k], x[pivot_[static_cast<std::size_t>(k)]]);
    Index steepest = 0;
    x.cwiseAbs().maxCoeff(&steepest);
    x.setZero();
    x[steepest] = 1;
  }
  return 1 / (norm_ * inverse_norm);
}

}  // namespace palpate
