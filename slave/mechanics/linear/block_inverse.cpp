#include "slave/mechanics/linear/block_inverse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/LU>

namespace palpate {
namespace {

// Row-major, of one block; no more than kLargestBlock squared numbers, none of them on the heap.
using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor,
                            BlockInverse::kLargestBlock, BlockInverse::kLargestBlock>;
using Lane = Eigen::Map<Eigen::Array<double, kLane, 1>>;
using ConstLane = Eigen::Map<const Eigen::Array<double, kLane, 1>>;

constexpr double kSmallestPivot = 1e-13;  // of the largest entry
constexpr double kGoodFactors = 1e-12;    // largest drift of factors without row exchanges

double Dot(const double* a, const double* b, int padded) {
  Eigen::Array<double, kLane, 1> sum = Eigen::Array<double, kLane, 1>::Zero();
  for (int j = 0; j < padded; j += kLane) sum += ConstLane(a + j) * ConstLane(b + j);
  return sum.sum();
}

// Four rows at a time: one alone would wait for its own sum.
void FourDots(const double* rows, int stride, const double* x, double* y, int padded) {
  using Values = Eigen::Array<double, kLane, 1>;
  std::array<Values, 4> sums;
  sums.fill(Values::Zero());
  for (int j = 0; j < padded; j += kLane) {
    const Values lane = ConstLane(x + j);
    for (std::size_t r = 0; r < 4; ++r) {
      sums[r] += ConstLane(rows + r * static_cast<std::size_t>(stride) + j) * lane;
    }
  }
  for (std::size_t r = 0; r < 4; ++r) y[r] = sums[r].sum();
}

void AddMultiple(double factor, const double* from, double* to, int padded) {
  for (int j = 0; j < padded; j += kLane) Lane(to + j) += factor * ConstLane(from + j);
}

bool InvertBlock(const Block& block, Block* inverse) {
  const double largest = block.cwiseAbs().maxCoeff();
  if (!(largest > 0 && std::isfinite(largest))) return false;
  if (block.rows() <= 2) {
    const double determinant =
        block.rows() == 1 ? block(0, 0) : block(0, 0) * block(1, 1) - block(0, 1) * block(1, 0);
    const double scale = block.rows() == 1 ? largest : largest * largest;
    if (!(std::abs(determinant) > kSmallestPivot * scale)) return false;
    if (block.rows() == 1) {
      *inverse = Block::Constant(1, 1, 1 / determinant);
    } else {
      inverse->resize(2, 2);
      *inverse << block(1, 1), -block(0, 1), -block(1, 0), block(0, 0);
      *inverse /= determinant;
    }
    return true;
  }
  const Eigen::PartialPivLU<Block> lu(block);
  if (!(lu.matrixLU().diagonal().cwiseAbs().minCoeff() > kSmallestPivot * largest)) return false;
  *inverse = lu.inverse();
  return true;
}

}  // namespace

void BlockInverse::Clear(int block) {
  if (block != block_) capacity_ = 0;
  block_ = block;
  blocks_ = 0;
  inverted_ = true;
}

void BlockInverse::Reserve(int blocks) {
  if (blocks <= capacity_) return;
  blocks = std::max(blocks, capacity_ + capacity_ / 2);
  const int order = blocks * block_;
  const int stride = OddLanes(order);
  const auto widened = [&](const std::vector<double>& old) {
    std::vector<double> wide(static_cast<std::size_t>(order) * static_cast<std::size_t>(stride));
    for (int i = 0; i < this->order(); ++i) {
      std::copy_n(old.data() + Offset(i), this->order(),
                  wide.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(stride));
    }
    return wide;
  };
  matrix_ = widened(matrix_);
  inverse_ = widened(inverse_);
  const auto lines = static_cast<std::size_t>(block_) * static_cast<std::size_t>(stride);
  columns_.assign(lines, 0.0);
  rows_.assign(lines, 0.0);
  factors_.assign(lines, 0.0);
  augmented_.assign(static_cast<std::size_t>(order * OddLanes(2 * PaddedTo(kLane, order))), 0.0);
  scratch_.assign(static_cast<std::size_t>(kPanel * order), 0.0);
  stride_ = stride;
  capacity_ = blocks;
}

bool BlockInverse::Append() {
  const int n = order();
  const int padded = PaddedTo(kLane, n);
  const int m = block_;
  const auto line = [&](std::vector<double>& lines, int c) { return lines.data() + Offset(c); };
  for (int c = 0; c < m; ++c) {
    for (int i = 0; i < n; ++i) line(columns_, c)[i] = matrix_row(i)[n + c];
    std::fill(line(columns_, c) + n, line(columns_, c) + padded, 0.0);
    std::fill_n(line(rows_, c), padded, 0.0);
  }
  for (int i = 0; i < n; ++i) {
    const double* x = inverse_row(i);
    for (int c = 0; c < m; ++c) {
      line(factors_, c)[i] = Dot(x, line(columns_, c), padded);
      AddMultiple(matrix_row(n + c)[i], x, line(rows_, c), padded);
    }
  }
  Block schur(m, m);
  for (int r = 0; r < m; ++r) {
    for (int c = 0; c < m; ++c) {
      double sum = matrix_row(n + r)[n + c];
      for (int i = 0; i < n; ++i) sum -= matrix_row(n + r)[i] * line(factors_, c)[i];
      schur(r, c) = sum;
    }
  }
  Block inverse;
  if (!InvertBlock(schur, &inverse)) {
    blocks_ = 0;
    return false;
  }
  for (int i = 0; i < n; ++i) {
    double* x = inverse_.data() + Offset(i);
    for (int c = 0; c < m; ++c) {
      double factor = 0;
      for (int k = 0; k < m; ++k) factor += line(factors_, k)[i] * inverse(k, c);
      AddMultiple(factor, line(rows_, c), x, padded);
      x[n + c] = -factor;
    }
  }
  for (int r = 0; r < m; ++r) {
    double* x = inverse_.data() + Offset(n + r);
    std::fill_n(x, PaddedTo(kLane, n + m), 0.0);
    for (int k = 0; k < m; ++k) AddMultiple(-inverse(r, k), line(rows_, k), x, padded);
    for (int c = 0; c < m; ++c) x[n + c] = inverse(r, c);
  }
  // The lane that begins with the block is new to the rows above.
  for (int i = 0; i < n; ++i) {
    double* x = inverse_.data() + Offset(i);
    std::fill(x + n + m, x + PaddedTo(kLane, n + m), 0.0);
  }
  ++blocks_;
  return true;
}

bool BlockInverse::Remove(int k) {
  const int n = order();
  const int padded = PaddedTo(kLane, n);
  const int m = block_;
  const int first = k * m;
  Block corner(m, m);
  for (int r = 0; r < m; ++r) {
    for (int c = 0; c < m; ++c) corner(r, c) = inverse_row(first + r)[first + c];
  }
  Block inverse;
  if (!InvertBlock(corner, &inverse)) {
    blocks_ = 0;
    return false;
  }
  const auto removed = [&](int c) { return inverse_.data() + Offset(first + c); };
  for (int i = 0; i < n; ++i) {
    if (i >= first && i < first + m) continue;
    double* x = inverse_.data() + Offset(i);
    Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kLargestBlock> factor =
        Eigen::Map<Eigen::RowVectorXd>(x + first, m) * inverse;
    for (int c = 0; c < m; ++c) AddMultiple(-factor[c], removed(c), x, padded);
  }
  MoveLastBlock(&inverse_, k);
  MoveLastBlock(&matrix_, k);
  --blocks_;
  return true;
}

// Rows and columns; what the last block leaves is zero.
void BlockInverse::MoveLastBlock(std::vector<double>* matrix, int to) const {
  const int n = order();
  const int m = block_;
  const int last = n - m;
  if (to * m != last) {
    for (int r = 0; r < m; ++r) {
      std::copy_n(matrix->data() + Offset(last + r), n, matrix->data() + Offset(to * m + r));
    }
  }
  for (int i = 0; i < last; ++i) {
    double* row = matrix->data() + Offset(i);
    if (to * m != last) std::copy_n(row + last, m, row + to * m);
    std::fill_n(row + last, m, 0.0);
  }
}

bool BlockInverse::Factorise() {
  inverted_ = false;
  entries_known_ = false;
  return (factor_.Factorise(matrix_.data(), stride_, order(), false, kSmallestPivot) &&
          Drift() <= kGoodFactors) ||
         Invert();
}

double BlockInverse::Entry(int i, int j) {
  if (inverted_) return inverse_row(i)[j];
  if (!entries_known_) factor_.InvertTriangles();
  entries_known_ = true;
  return factor_.InverseEntry(i, j);
}

bool BlockInverse::Invert() {
  inverted_ = true;
  const int n = order();
  const int padded = PaddedTo(kLane, n);
  const RowMajor system{augmented_.data(), OddLanes(2 * padded)};
  for (int i = 0; i < n; ++i) {
    double* row = system.row(i);
    std::copy_n(matrix_row(i), n, row);
    std::fill(row + n, row + system.stride, 0.0);
    row[padded + i] = 1;
  }
  if (!SolveInPlace(system, n, scratch_.data())) {
    blocks_ = 0;
    return false;
  }
  for (int i = 0; i < n; ++i) {
    std::copy_n(system.row(i) + padded, padded, inverse_.data() + Offset(i));
  }
  return true;
}

void BlockInverse::Multiply(const double* x, double* y) const noexcept {
  if (!inverted_) return factor_.Solve(x, y);
  const int n = order();
  const int padded = PaddedTo(kLane, n);
  int i = 0;
  for (; i + 4 <= n; i += 4) FourDots(inverse_row(i), stride_, x, y + i, padded);
  for (; i < n; ++i) y[i] = Dot(inverse_row(i), x, padded);
  std::fill(y + n, y + padded, 0.0);
}

double BlockInverse::Drift() {
  const int n = order();
  const int padded = PaddedTo(kLane, n);
  double* v = columns_.data();
  double* y = rows_.data();
  // The fractions of multiples of the golden ratio, less a half.
  for (int i = 0; i < padded; ++i) {
    const double multiple = 0.6180339887498949 * (i + 1);
    v[i] = i < n ? multiple - std::floor(multiple) - 0.5 : 0;
  }
  Multiply(v, y);
  double largest = 0;
  for (int i = 0; i < n; ++i) {
    double sum = -v[i];
    const double* row = matrix_row(i);
    for (int j = 0; j < n; ++j) sum += row[j] * y[j];
    largest = std::max(largest, std::abs(sum));
  }
  return std::isfinite(largest) ? 2 * largest : largest;
}

}  // namespace palpate
