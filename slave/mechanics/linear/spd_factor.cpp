#include "slave/mechanics/linear/spd_factor.h"

#include <stdexcept>

#include "slave/mechanics/linear/elimination_order.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

std::vector<int> OrderOf(const Matrix& lower) {
  std::vector<std::vector<int>> neighbours(Index(static_cast<int>(lower.cols())));
  for (int column = 0; column < lower.cols(); ++column) {
    for (Matrix::InnerIterator entry(lower, column); entry; ++entry) {
      const int row = static_cast<int>(entry.row());
      neighbours[Index(column)].push_back(row);
      if (row != column) neighbours[Index(row)].push_back(column);
    }
  }
  return EliminationOrder(neighbours);
}

Matrix InOrder(const Matrix& lower, const std::vector<int>& order) {
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> rank(lower.cols());
  for (std::size_t i = 0; i < order.size(); ++i) rank.indices()[order[i]] = static_cast<int>(i);
  Matrix upper(lower.rows(), lower.cols());
  upper.selfadjointView<Eigen::Upper>() = lower.selfadjointView<Eigen::Lower>().twistedBy(rank);
  return upper;
}

}  // namespace

SpdFactor::SpdFactor(const Matrix& lower) : order_(OrderOf(lower)) {
  const Matrix upper = InOrder(lower, order_);
  factor_.emplace(upper);
  factor_->Allocate(upper);
  if (factor_->Factorize(upper, true)) return;
  throw std::invalid_argument(
      "stiffness: expected a positive definite one; the supports leave "
      "the body free to move, or an element is too distorted");
}

void SpdFactor::Solve(double* columns, int count) {
  const auto rows = static_cast<Eigen::Index>(order_.size());
  Eigen::Map<Eigen::MatrixXd> x(columns, rows, count);
  Eigen::MatrixXd ordered(rows, count);
  for (int c = 0; c < count; ++c) {
    for (Eigen::Index i = 0; i < rows; ++i)
      ordered(i, c) = x(order_[static_cast<std::size_t>(i)], c);
  }
  factor_->Solve(ordered);
  for (int c = 0; c < count; ++c) {
    for (Eigen::Index i = 0; i < rows; ++i)
      x(order_[static_cast<std::size_t>(i)], c) = ordered(i, c);
  }
}

}  // namespace palpate
