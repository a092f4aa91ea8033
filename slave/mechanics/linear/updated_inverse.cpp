#include "slave/mechanics/linear/updated_inverse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <Eigen/LU>

namespace palpate {
namespace {

// Of the unknown's own compliance: below, a contact is the same as others together.
constexpr double kLeastPivot = 1e-11;
constexpr double kDrifted = 1e-11;  // error of the probe after an update, its size being one
constexpr double kHopeless = 1e-5;  // the same of a fresh inverse

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Strided = Eigen::Map<RowMatrix, 0, Eigen::OuterStride<>>;
struct alignas(64) Tile {
  std::array<double, kLane8 * kLane8> a{};
  double* row(int i) { return a.data() + static_cast<long>(i) * kLane8; }
};

void CopyRows(const double* from, int ldf, double* to, int ldt, int length) {
  for (int r = 0; r < kLane8; ++r, from += ldf, to += ldt) std::copy_n(from, length, to);
}

// The upper triangle of a symmetric tile from the lower one.
void MirrorTile(double* tile) {
  for (int r = 1; r < kLane8; ++r) {
    for (int c = 0; c < r; ++c) tile[c * kLane8 + r] = tile[r * kLane8 + c];
  }
}

// The upper triangle of a symmetric matrix from the lower one.
void Mirror(double* a, int stride, int order) {
  const auto tile = [&](int i, int j) { return a + static_cast<long>(i) * stride + j; };
  for (int i = 0; i < order; i += kLane8) {
    for (int j = 0; j < i; j += kLane8) Transpose8(tile(i, j), stride, tile(j, i), stride);
    for (int r = 1; r < kLane8; ++r) {
      for (int c = 0; c < r; ++c) tile(i + c, i)[r] = tile(i + r, i)[c];
    }
  }
}

// Moves what follows the removed unknowns to behind the inserted ones.
void Shift(double* a, int stride, int order, int first, int removed, int inserted) {
  const int by = inserted - removed;
  if (by == 0) return;
  const int tail = order - first - removed;
  const auto move = [&](int from_row, int to_row) {
    double* from = a + static_cast<long>(from_row) * stride;
    double* to = a + static_cast<long>(to_row) * stride;
    if (from != to) std::memcpy(to, from, static_cast<std::size_t>(first) * sizeof(double));
    std::memmove(to + first + inserted, from + first + removed,
                 static_cast<std::size_t>(tail) * sizeof(double));
    if (by < 0) std::fill(to + order + by, to + order, 0.0);
  };
  for (int i = 0; i < first; ++i) move(i, i);
  if (by < 0) {
    for (int i = first + removed; i < order; ++i) move(i, i + by);
    for (int i = order + by; i < order; ++i) {
      std::fill_n(a + static_cast<long>(i) * stride, stride, 0.0);
    }
  } else {
    for (int i = order - 1; i >= first + removed; --i) move(i, i + by);
  }
}

void FillIdentity(Tile* tile) {
  tile->a.fill(0);
  for (int i = 0; i < kLane8; ++i) tile->row(i)[i] = 1;
}

}  // namespace

void UpdatedInverse::Reset(int order) {
  order_ = order;
  if (PaddedTo8(order) > capacity_) {
    capacity_ = PaddedTo8(order + order / 4);
    stride_ = capacity_ | kLane8;  // an odd number of lanes: rows do not fall on the same cache set
    // The last unknown's block of three may overhang.
    const auto area =
        static_cast<std::size_t>(capacity_ + kLane8) * static_cast<std::size_t>(stride_);
    matrix_ = MakeAligned(area);
    inverse_ = MakeAligned(area);
    const auto slab = static_cast<std::size_t>(kLane8) * static_cast<std::size_t>(stride_);
    for (auto* array : {&panel_, &panel_by_pivot_, &rows_, &probe_, &image_, &returned_}) {
      *array = MakeAligned(slab);
    }
  }
}

std::size_t UpdatedInverse::memory_bytes() const {
  return sizeof(double) * 2 * static_cast<std::size_t>(capacity_) *
             static_cast<std::size_t>(stride_) +
         factor_.memory_bytes();
}

bool UpdatedInverse::Invert() {
  inverted_ = true;
  if (order_ == 0) return true;
  ++inversions_;
  if (order_ <= 3) return InvertUpTo3();
  Complete();
  if (InvertBySweeps() && ProbeError() <= kHopeless) return true;
  return !symmetric_ && InvertByPivoting() && ProbeError() <= kHopeless;
}

bool UpdatedInverse::Factorise() {
  if (order_ <= 3) return Invert();
  inverted_ = blocks_ready_ = false;
  Complete();
  const bool good = factor_.Factorise(matrix_.get(), stride_, order_, symmetric_, kLeastPivot) &&
                    ProbeError() <= kHopeless;
  return good || Invert();
}

void UpdatedInverse::Complete() {
  if (symmetric_) Mirror(matrix_.get(), stride_, padded());
  for (int i = 0; i < padded(); ++i) {  // what is left of larger matrices
    std::fill(row(i) + (i < order_ ? order_ : 0), row(i) + padded(), 0.0);
  }
}

void UpdatedInverse::InverseBlock(int row, int column, double* block) const noexcept {
  if (!inverted_) {
    const int from = std::max(row, column) / kLane8 * kLane8;
    ThreeByThreeDots(factor_.row_of_left(row) + from, factor_.row_of_right(column) + from,
                     factor_.stride(), factor_.size() - from, block);
    return;
  }
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) block[3 * r + c] = inverse_row(row + r)[column + c];
  }
}

// Upper triangle from the lower one, tile by tile.
bool UpdatedInverse::InvertUpTo3() {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  for (int i = 0; i < order_; ++i) {
    for (int j = 0; j < order_; ++j) {
      if (symmetric_ && j > i) row(i)[j] = row(j)[i];
      m(i, j) = row(i)[j];
    }
  }
  Eigen::Matrix3d p;
  double volume = 0;
  bool invertible = false;
  m.computeInverseAndDetWithCheck(p, volume, invertible, 0.0);
  const double largest = m(0, 0) * m(1, 1) * m(2, 2);
  if (!(volume > kLeastPivot * largest) || !(largest > 0)) return false;
  for (int i = 0; i < kLane8; ++i) std::fill_n(InverseRow(i), kLane8, 0.0);
  for (int i = 0; i < order_; ++i) {
    for (int j = 0; j < order_; ++j) InverseRow(i)[j] = p(i, j);
  }
  return true;
}

bool UpdatedInverse::InvertBySweeps() {
  const int size = padded();
  for (int i = 0; i < order_; ++i) {
    std::memcpy(InverseRow(i), row(i), static_cast<std::size_t>(size) * sizeof(double));
    std::fill(InverseRow(i) + order_, InverseRow(i) + size, 0.0);
  }
  for (int i = order_; i < size; ++i) {
    std::fill_n(InverseRow(i), size, 0.0);
    InverseRow(i)[i] = 1;
  }
  for (int panel = 0; panel < size; panel += kLane8) {
    if (!Sweep(panel)) return false;
  }
  for (int i = 0; i < size; ++i) {
    const int end = symmetric_ ? i + 1 : size;
    for (int j = 0; j < end; ++j) InverseRow(i)[j] = -InverseRow(i)[j];
  }
  if (symmetric_) Mirror(inverse_.get(), stride_, padded());
  for (int i = order_; i < size; ++i) std::fill_n(InverseRow(i), size, 0.0);
  return true;
}

// A_ij -= A_iK D A_Kj with D = (A_KK)^-1; then A_iK = A_iK D, A_Kj = D A_Kj, A_KK = -D. Where the
// matrix is symmetric, so is everything here, and only the lower triangle is worked on.
bool UpdatedInverse::Sweep(int panel) {
  const int size = padded();
  Tile D;
  CopyRows(InverseRow(panel) + panel, stride_, D.a.data(), kLane8, kLane8);
  if (symmetric_) MirrorTile(D.a.data());
  std::array<double, kLane8> least{};
  for (int r = 0; r < kLane8; ++r) {
    const int i = panel + r;
    least[static_cast<std::size_t>(r)] = i < order_ ? kLeastPivot * row(i)[i] : 0;
    if (!(least[static_cast<std::size_t>(r)] >= 0)) return false;
  }
  if (!Invert8(D.a.data(), least.data())) return false;
  double* columns = panel_.get();  // A_:K, size x 8
  double* rows = rows_.get();      // A_K:, 8 x stride
  for (int i = 0; i < size; i += kLane8) {
    double* to = columns + static_cast<long>(i) * kLane8;
    if (symmetric_ && i < panel) {
      Transpose8(InverseRow(panel) + i, stride_, to, kLane8);
    } else {
      CopyRows(InverseRow(i) + panel, stride_, to, kLane8, kLane8);
    }
    if (symmetric_ && i == panel) MirrorTile(to);
    if (symmetric_) Transpose8(to, kLane8, rows + i, stride_);
  }
  if (!symmetric_) CopyRows(InverseRow(panel), stride_, rows, stride_, size);
  double* by_pivot = panel_by_pivot_.get();
  MultiplyPanel(columns, D.a.data(), size, by_pivot);
  SubtractProduct(inverse_.get(), stride_, by_pivot, rows, stride_, size, kLane8, symmetric_);
  for (int i = 0; i < size; i += kLane8) {
    const double* tile = by_pivot + static_cast<long>(i) * kLane8;
    if (symmetric_ && i < panel) {
      Transpose8(tile, kLane8, InverseRow(panel) + i, stride_);
    } else {
      CopyRows(tile, kLane8, InverseRow(i) + panel, stride_, kLane8);
    }
  }
  for (int r = 0; r < kLane8; ++r) {
    double* to = InverseRow(panel + r);
    if (!symmetric_) {
      std::fill_n(to, size, 0.0);
      for (int q = 0; q < kLane8; ++q) {
        const double* from = rows + static_cast<long>(q) * stride_;
        for (int j = 0; j < size; ++j) to[j] += D.row(r)[q] * from[j];
      }
    }
    for (int c = 0; c < kLane8; ++c) to[panel + c] = -D.row(r)[c];
  }
  return true;
}

bool UpdatedInverse::InvertByPivoting() {
  const Strided m(matrix_.get(), order_, order_, Eigen::OuterStride<>(stride_));
  if (!m.allFinite()) return false;
  const Eigen::FullPivLU<RowMatrix> lu(m);
  if (!lu.isInvertible()) return false;
  for (int i = 0; i < padded(); ++i) std::fill_n(InverseRow(i), padded(), 0.0);
  Strided(inverse_.get(), order_, order_, Eigen::OuterStride<>(stride_)) = lu.inverse();
  return true;
}

void UpdatedInverse::ClearInverse(int first, int count) {
  for (int i = 0; i < padded(); ++i) std::fill_n(InverseRow(i) + first, count, 0.0);
  for (int i = first; i < first + count; ++i) std::fill_n(InverseRow(i), padded(), 0.0);
}

void UpdatedInverse::TakeOut(int first, int count) {
  Tile D;
  FillIdentity(&D);
  for (int r = 0; r < count; ++r) {
    for (int c = 0; c < count; ++c) D.row(r)[c] = InverseRow(first + r)[first + c];
  }
  const std::array<double, kLane8> least{};
  Invert8(D.a.data(), least.data());  // a drifted one is found by the probe
  double* columns = panel_.get();
  for (int i = 0; i < padded(); ++i) {
    for (int c = 0; c < kLane8; ++c) {
      columns[i * kLane8 + c] = c < count ? InverseRow(i)[first + c] : 0;
    }
  }
  for (int r = 0; r < count; ++r) {
    std::memcpy(rows_.get() + static_cast<long>(r) * stride_, InverseRow(first + r),
                static_cast<std::size_t>(padded()) * sizeof(double));
  }
  MultiplyPanel(columns, D.a.data(), padded(), panel_by_pivot_.get());
  SubtractProduct(inverse_.get(), stride_, panel_by_pivot_.get(), rows_.get(), stride_, padded(),
                  count, false);
  ClearInverse(first, count);
}

bool UpdatedInverse::Splice(int first, int removed, int inserted) {
  if (!inverted_ || PaddedTo8(order_ - removed + inserted) > capacity_) return false;
  for (int done = 0; done < removed; done += kLane8) {
    TakeOut(first + done, std::min(kLane8, removed - done));
  }
  for (int i = padded(); i < PaddedTo8(order_ - removed + inserted); ++i) {
    std::fill_n(InverseRow(i), stride_, 0.0);
    for (int j = 0; j < i; ++j) InverseRow(j)[i] = 0;
  }
  Shift(matrix_.get(), stride_, order_, first, removed, inserted);
  Shift(inverse_.get(), stride_, order_, first, removed, inserted);
  order_ += inserted - removed;
  ClearInverse(first, inserted);
  return true;
}

bool UpdatedInverse::Border(int first, int count) {
  if (symmetric_) {
    for (int i = first; i < first + count; ++i) {
      for (int j = 0; j < order_; ++j) row(j)[i] = row(i)[j];
    }
  }
  for (int done = 0; done < count; done += kLane8) {
    if (!BorderPanel(first + done, std::min(kLane8, count - done))) return false;
  }
  return true;
}

// What is not bordered yet is zero in the inverse and takes no part.
bool UpdatedInverse::BorderPanel(int at, int size) {
  FillBorder(at, size);
  const double* V = panel_.get();
  Tile s;
  FillIdentity(&s);
  std::array<double, kLane8> least{};
  for (int r = 0; r < size; ++r) {
    least[static_cast<std::size_t>(r)] = kLeastPivot * row(at + r)[at + r];
    for (int k = 0; k < size; ++k) {
      double sum = row(at + r)[at + k];
      for (int i = 0; i < order_; ++i) sum -= row(at + r)[i] * V[i * kLane8 + k];
      s.row(r)[k] = sum;
    }
  }
  if (!Invert8(s.a.data(), least.data())) return false;
  double* Vs = panel_by_pivot_.get();  // - V s
  MultiplyPanel(V, s.a.data(), padded(), Vs);
  for (int i = 0; i < padded() * kLane8; ++i) Vs[i] = -Vs[i];
  SubtractProduct(inverse_.get(), stride_, Vs, rows_.get(), stride_, padded(), size, false);
  for (int i = 0; i < order_; ++i) {
    for (int q = 0; q < size; ++q) InverseRow(i)[at + q] = Vs[i * kLane8 + q];
  }
  for (int r = 0; r < size; ++r) {
    double* to = InverseRow(at + r);
    std::fill_n(to, order_, 0.0);
    for (int q = 0; q < size; ++q) {  // - s W
      const double* W = rows_.get() + static_cast<long>(q) * stride_;
      for (int j = 0; j < order_; ++j) to[j] -= s.row(r)[q] * W[j];
    }
    for (int q = 0; q < size; ++q) to[at + q] = s.row(r)[q];
  }
  return true;
}

// V = P c into panel_, order x 8; W = r P into rows_, 8 x stride: c the new columns, r the new
// rows.
void UpdatedInverse::FillBorder(int at, int size) {
  double* V = panel_.get();
  double* c = image_.get();  // transposed, 8 x stride
  for (int q = 0; q < size; ++q) {
    double* to = c + static_cast<long>(q) * stride_;
    for (int i = 0; i < order_; ++i) to[i] = symmetric_ ? row(at + q)[i] : row(i)[at + q];
    std::fill(to + order_, to + padded(), 0.0);
  }
  std::fill_n(V, padded() * kLane8, 0.0);
  RowDots(inverse_.get(), stride_, c, stride_, padded(), size, V);
  for (int q = 0; q < size; ++q) {
    double* W = rows_.get() + static_cast<long>(q) * stride_;
    if (symmetric_) {
      for (int i = 0; i < padded(); ++i) W[i] = V[i * kLane8 + q];
      continue;
    }
    std::fill_n(W, padded(), 0.0);
    for (int i = 0; i < order_; ++i) {
      const double factor = row(at + q)[i];
      for (int j = 0; j < padded(); ++j) W[j] += factor * InverseRow(i)[j];
    }
  }
}

// Largest difference between a vector of signs and what comes back from the matrix and its inverse.
double UpdatedInverse::ProbeError() {
  double* x = probe_.get();
  for (int i = 0; i < padded(); ++i) x[i] = i >= order_ ? 0 : (i * 5 / 3 % 2 == 0 ? 1 : -1);
  RowDot(matrix_.get(), stride_, x, padded(), image_.get());
  std::fill(image_.get() + order_, image_.get() + padded(), 0.0);
  Solve(image_.get(), returned_.get());
  double error = 0;
  for (int i = 0; i < order_; ++i) {
    const double off = std::abs(returned_[static_cast<std::size_t>(i)] - x[i]);
    if (!(off <= error)) error = off;
  }
  return std::isfinite(error) ? error : 1e300;
}

bool UpdatedInverse::Settle() {
  return order_ == 0 || ProbeError() <= kDrifted || Invert();
}

}  // namespace palpate
