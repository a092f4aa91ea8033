#include "slave/mechanics/linear/dense_factor.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {

std::size_t DenseFactor::memory_bytes() const {
  return sizeof(double) * static_cast<std::size_t>(capacity_) *
         static_cast<std::size_t>(3 * stride_);
}

bool DenseFactor::Factorise(const double* a, int lda, int order, bool symmetric,
                            double least_pivot) {
  order_ = order;
  symmetric_ = symmetric;
  const int size = PaddedTo8(order);
  if (size > capacity_) {
    capacity_ = PaddedTo8(order + order / 4);
    stride_ = capacity_ | kLane8;  // an odd number of lanes: rows do not fall on the same cache set
    const auto area =
        static_cast<std::size_t>(capacity_ + kLane8) * static_cast<std::size_t>(stride_);
    for (auto* array : {&factors_, &left_, &right_}) *array = MakeAligned(area);
    inverses_ = MakeAligned(static_cast<std::size_t>(capacity_) * kLane8);
    panel_ = MakeAligned(static_cast<std::size_t>(stride_) * kLane8);
  }
  Copy(a, lda);
  for (int k = 0; k < size; k += kLane8) {
    const int next = k + kLane8;
    SubtractWide(Tile(k, k), Tile(k, 0), Tile(0, k), stride_, k, size - k);
    if (!InvertTile(k, a, lda, least_pivot)) return false;
    if (symmetric) {
      for (int i = next; i < size; i += kLane8) {
        Transpose8(Tile(k, i), stride_, Tile(i, k), stride_);
      }
    } else if (next < size) {
      SubtractTall(Tile(next, k), Tile(next, 0), Tile(0, k), stride_, k, size - next);
    }
    if (next < size) {
      MultiplyLeft(InverseTile(k), Tile(k, next), stride_, size - next);
    }
  }
  return true;
}

void DenseFactor::Copy(const double* a, int lda) {
  const int size = PaddedTo8(order_);
  for (int i = 0; i < size; ++i) {
    double* to = Tile(i, 0);
    const int first = symmetric_ ? i / kLane8 * kLane8 : 0;
    const int last = i < order_ ? order_ : first;
    std::copy(a + static_cast<long>(i) * lda + first, a + static_cast<long>(i) * lda + last,
              to + first);
    std::fill(to + last, to + size, 0.0);
    if (i >= order_) to[i] = 1;
  }
}

bool DenseFactor::InvertTile(int k, const double* a, int lda, double least_pivot) {
  double* inverse = InverseTile(k);
  std::array<double, kLane8> least{};
  for (int r = 0; r < kLane8; ++r) {
    std::copy_n(Tile(k + r, k), kLane8, inverse + static_cast<long>(r) * kLane8);
    if (k + r >= order_) continue;
    double& bound = least[static_cast<std::size_t>(r)];
    bound = least_pivot * a[static_cast<long>(k + r) * (lda + 1)];
    if (!(bound >= 0 && std::isfinite(bound))) return false;
  }
  return Invert8(inverse, least.data());
}

void DenseFactor::InvertTriangles() {
  InvertLeft();
  InvertRight();
}

// V = W^-1 from the last row on: V_k = I_k - W_k,>k V_>k.
void DenseFactor::InvertLeft() {
  const int size = this->size();
  for (int k = size - kLane8; k >= 0; k -= kLane8) {
    double* rows = left_.get() + Offset(k, k);
    for (int r = 0; r < kLane8; ++r) {
      std::fill_n(rows + Offset(r, 0), size - k, 0.0);
      rows[Offset(r, r)] = 1;
    }
    const int next = k + kLane8;
    if (next == size) continue;
    SubtractByUpper(rows + kLane8, Tile(k, next), left_.get() + Offset(next, next), stride_,
                    size - next);
  }
}

// The same for L^T, whose tiles on the diagonal are not unit ones; where the matrix is symmetric,
// L^T = D W, D those tiles.
void DenseFactor::InvertRight() {
  const int size = this->size();
  if (symmetric_) {
    for (int k = 0; k < size; k += kLane8) {
      MultiplyRight(left_.get() + k, InverseTile(k), right_.get() + k, stride_, k + kLane8);
    }
    return;
  }
  alignas(64) std::array<double, kLane8 * kLane8> transposed;
  for (int k = size - kLane8; k >= 0; k -= kLane8) {
    const int next = k + kLane8;
    double* rows = right_.get() + Offset(k, k);
    for (int r = 0; r < kLane8; ++r) std::fill_n(rows + Offset(r, 0), size - k, 0.0);
    Transpose8(InverseTile(k), kLane8, transposed.data(), kLane8);
    for (int i = next; i < size; i += kLane8) {
      Transpose8(Tile(i, k), stride_, panel_.get() + i, stride_);
    }
    if (next < size) {
      SubtractByUpper(rows + kLane8, panel_.get() + next, right_.get() + Offset(next, next),
                      stride_, size - next);
      MultiplyLeft(transposed.data(), rows + kLane8, stride_, size - next);
    }
    for (int r = 0; r < kLane8; ++r) {
      std::copy_n(transposed.data() + static_cast<long>(r) * kLane8, kLane8, rows + Offset(r, 0));
    }
  }
}

double DenseFactor::InverseEntry(int i, int j) const noexcept {
  std::array<double, 4> sums{};
  for (int q = std::max(i, j) / kLane8 * kLane8; q < size(); q += 4) {
    for (int l = 0; l < 4; ++l) {
      sums[static_cast<std::size_t>(l)] += row_of_left(i)[q + l] * row_of_right(j)[q + l];
    }
  }
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

void DenseFactor::Solve(const double* b, double* x) const noexcept {
  const int size = PaddedTo8(order_);
  alignas(64) std::array<double, kLane8> sums;
  for (int k = 0; k < size; k += kLane8) {
    EightDots(Tile(k, 0), stride_, x, k, sums.data());
    for (int r = 0; r < kLane8; ++r) {
      double& sum = sums[static_cast<std::size_t>(r)];
      sum = b[k + r] - sum;
    }
    EightDots(InverseTile(k), kLane8, sums.data(), kLane8, x + k);
  }
  for (int k = size - 2 * kLane8; k >= 0; k -= kLane8) {
    const int next = k + kLane8;
    EightDots(Tile(k, next), stride_, x + next, size - next, sums.data());
    for (int r = 0; r < kLane8; ++r) x[k + r] -= sums[static_cast<std::size_t>(r)];
  }
}

}  // namespace palpate
