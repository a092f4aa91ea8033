#include "slave/mechanics/bem3d/block_lu.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace palpate {
namespace {

constexpr int kHagerSteps = 5;  // his estimate hardly ever needs more than three
constexpr int kLeaf = 8;        // columns of a panel that are eliminated one by one

}  // namespace

BlockLu::BlockLu(Eigen::MatrixXd A) : A_(std::move(A)) {
  swapped_.resize(static_cast<std::size_t>(order()));
  norm_ = A_.cwiseAbs().colwise().sum().maxCoeff();
}

bool BlockLu::FactorizeNext() {
  const int begin = done_ * kWidth;
  const int end = std::min(begin + kWidth, order());
  Columns columns = A_.middleCols(begin, end - begin);
  SwapRows(columns, 0, begin);
  TakeUpLeft(columns, begin);
  if (!FactorizePanel(begin, end)) return false;
  SwapRows(A_.leftCols(begin), begin, end);
  ++done_;
  return true;
}

std::vector<double> BlockLu::LastBlock() const {
  const int begin = (done_ - 1) * kWidth;
  const int end = std::min(begin + kWidth, order());
  std::vector<double> block(swapped_.begin() + begin, swapped_.begin() + end);
  block.insert(block.end(), A_.col(begin).data(), A_.data() + Eigen::Index{end} * order());
  return block;
}

bool BlockLu::AdoptNext(const std::vector<double>& block) {
  const int begin = done_ * kWidth;
  const int end = std::min(begin + kWidth, order());
  const auto columns = static_cast<std::size_t>(std::max(0, end - begin));
  if (columns == 0 || block.size() != columns * static_cast<std::size_t>(order() + 1)) return false;
  for (std::size_t k = 0; k < columns; ++k) {
    const int row = begin + static_cast<int>(k);
    if (!(block[k] >= row && block[k] < order())) return false;
    swapped_[static_cast<std::size_t>(row)] = static_cast<int>(block[k]);
  }
  std::copy(block.begin() + end - begin, block.end(), A_.col(begin).data());
  SwapRows(A_.leftCols(begin), begin, end);
  ++done_;
  return true;
}

void BlockLu::SolveInPlace(Columns B) const {
  SwapRows(B, 0, order());
  A_.triangularView<Eigen::UnitLower>().solveInPlace(B);
  A_.triangularView<Eigen::Upper>().solveInPlace(B);
}

double BlockLu::Condition() const {
  const int n = order();
  Eigen::VectorXd x = Eigen::VectorXd::Constant(n, 1.0 / n);
  double inverse_norm = 0;
  for (int step = 0; step < kHagerSteps; ++step) {
    const Eigen::VectorXd start = x;
    SolveInPlace(x);
    inverse_norm = std::max(inverse_norm, x.lpNorm<1>());
    const Eigen::VectorXd signs = x.unaryExpr([](double v) { return v < 0 ? -1.0 : 1.0; });
    const Eigen::VectorXd slope = SolveTransposed(signs);
    Eigen::Index steepest = 0;
    const double most = slope.cwiseAbs().maxCoeff(&steepest);
    if (!(most > slope.dot(start))) break;
    x = Eigen::VectorXd::Unit(n, steepest);
  }
  return norm_ * inverse_norm;
}

// The swaps of the columns [begin, end), in order.
void BlockLu::SwapRows(Columns columns, int begin, int end) const {
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    double* column = columns.col(j).data();
    for (int k = begin; k < end; ++k) {
      std::swap(column[k], column[swapped_[static_cast<std::size_t>(k)]]);
    }
  }
}

// Eliminates with the first `count` columns of L.
void BlockLu::TakeUpLeft(Columns columns, int count) const {
  if (count == 0) return;
  auto top = columns.topRows(count);
  A_.topLeftCorner(count, count).triangularView<Eigen::UnitLower>().solveInPlace(top);
  const int below = order() - count;
  columns.bottomRows(below).noalias() -= A_.bottomLeftCorner(below, count) * top;
}

// The columns [begin, end) from row `begin` on, by halves.
bool BlockLu::FactorizePanel(int begin, int end) {
  if (end - begin <= kLeaf) return FactorizeLeaf(begin, end);
  const int middle = begin + (end - begin) / 2;
  if (!FactorizePanel(begin, middle)) return false;
  const int left = middle - begin;
  const int right = end - middle;
  SwapRows(A_.middleCols(middle, right), begin, middle);
  auto top = A_.block(begin, middle, left, right);
  A_.block(begin, begin, left, left).triangularView<Eigen::UnitLower>().solveInPlace(top);
  const int below = order() - middle;
  A_.block(middle, middle, below, right).noalias() -= A_.block(middle, begin, below, left) * top;
  if (!FactorizePanel(middle, end)) return false;
  SwapRows(A_.middleCols(begin, left), middle, end);
  return true;
}

bool BlockLu::FactorizeLeaf(int begin, int end) {
  for (int k = begin; k < end; ++k) {
    Eigen::Index pivot = 0;
    const double largest = A_.col(k).tail(order() - k).cwiseAbs().maxCoeff(&pivot);
    if (!(largest > 0 && std::isfinite(largest))) return false;
    swapped_[static_cast<std::size_t>(k)] = k + static_cast<int>(pivot);
    SwapRows(A_.middleCols(begin, end - begin), k, k + 1);
    const int below = order() - k - 1;
    const int right = end - k - 1;
    A_.col(k).tail(below) /= A_(k, k);
    A_.block(k + 1, k + 1, below, right).noalias() -=
        A_.col(k).tail(below) * A_.row(k).segment(k + 1, right);
  }
  return true;
}

Eigen::VectorXd BlockLu::SolveTransposed(Eigen::VectorXd b) const {
  A_.triangularView<Eigen::Upper>().transpose().solveInPlace(b);
  A_.triangularView<Eigen::UnitLower>().transpose().solveInPlace(b);
  for (int k = order() - 1; k >= 0; --k) {
    std::swap(b[k], b[swapped_[static_cast<std::size_t>(k)]]);
  }
  return b;
}

}  // namespace palpate
