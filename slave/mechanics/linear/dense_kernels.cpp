#include "slave/mechanics/linear/dense_kernels.h"

#include <algorithm>
#include <new>

#include "slave/mechanics/linear/lanes.h"

namespace palpate {
namespace {

using Lane = double __attribute__((vector_size(64), may_alias));

using LooseLane = double __attribute__((vector_size(64), aligned(8), may_alias));

constexpr std::size_t kAlignment = 64;

[[gnu::always_inline]] inline const Lane& At(const double* p) {
  return *reinterpret_cast<const Lane*>(p);
}
[[gnu::always_inline]] inline Lane& At(double* p) {
  return *reinterpret_cast<Lane*>(p);
}

// kRows x kLanes tiles of C -= A B, that stay in registers over the whole depth.
template <int kRows, int kLanes>
[[gnu::always_inline]] inline void SubtractTile(double* c, const double* a, const double* b,
                                                long ld, int depth) {
  Lane sum[kRows][kLanes];
#pragma GCC unroll 24
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 3
    for (int l = 0; l < kLanes; ++l) sum[r][l] = At(c + r * ld + l * kLane8);
  }
  for (int q = 0; q < depth; ++q, b += ld, ++a) {
    Lane factors[kLanes];
#pragma GCC unroll 3
    for (int l = 0; l < kLanes; ++l) factors[l] = At(b + l * kLane8);
#pragma GCC unroll 24
    for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 3
      for (int l = 0; l < kLanes; ++l) sum[r][l] -= a[r * ld] * factors[l];
    }
  }
#pragma GCC unroll 24
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 3
    for (int l = 0; l < kLanes; ++l) At(c + r * ld + l * kLane8) = sum[r][l];
  }
}

}  // namespace

void AlignedFree::operator()(double* memory) const noexcept {
  ::operator delete(memory, std::align_val_t(kAlignment));
}

AlignedArray MakeAligned(std::size_t count) {
  auto* memory = static_cast<double*>(::operator new(
      std::max<std::size_t>(count, 1) * sizeof(double), std::align_val_t(kAlignment)));
  std::fill_n(memory, count, 0.0);
  return AlignedArray(memory);
}

// Two lanes wide where it fits: every factor that is fetched serves both.
PALPATE_DISPATCHED
void SubtractProduct(double* c, int ldc, const double* a, const double* b, int ldb, int order,
                     int depth, bool lower) noexcept {
  for (int i = 0; i < order; i += kLane8) {
    const double* a_tile = a + static_cast<long>(i) * kLane8;
    double* c_rows = c + static_cast<long>(i) * ldc;
    const int end = lower ? i + kLane8 : order;
    int j = 0;
    for (; j + 2 * kLane8 <= end; j += 2 * kLane8) {
      Lane left[kLane8], right[kLane8];
      for (int r = 0; r < kLane8; ++r) {
        left[r] = At(c_rows + static_cast<long>(r) * ldc + j);
        right[r] = At(c_rows + static_cast<long>(r) * ldc + j + kLane8);
      }
      for (int q = 0; q < depth; ++q) {
        const Lane b_left = At(b + static_cast<long>(q) * ldb + j);
        const Lane b_right = At(b + static_cast<long>(q) * ldb + j + kLane8);
        for (int r = 0; r < kLane8; ++r) {
          left[r] -= a_tile[r * kLane8 + q] * b_left;
          right[r] -= a_tile[r * kLane8 + q] * b_right;
        }
      }
      for (int r = 0; r < kLane8; ++r) {
        At(c_rows + static_cast<long>(r) * ldc + j) = left[r];
        At(c_rows + static_cast<long>(r) * ldc + j + kLane8) = right[r];
      }
    }
    for (; j < end; j += kLane8) {
      Lane tile[kLane8];
      for (int r = 0; r < kLane8; ++r) tile[r] = At(c_rows + static_cast<long>(r) * ldc + j);
      for (int q = 0; q < depth; ++q) {
        const Lane b_row = At(b + static_cast<long>(q) * ldb + j);
        for (int r = 0; r < kLane8; ++r) tile[r] -= a_tile[r * kLane8 + q] * b_row;
      }
      for (int r = 0; r < kLane8; ++r) At(c_rows + static_cast<long>(r) * ldc + j) = tile[r];
    }
  }
}

PALPATE_DISPATCHED
void MultiplyPanel(const double* panel, const double* tile, int order, double* out) noexcept {
  Lane rows[kLane8];
  for (int q = 0; q < kLane8; ++q) rows[q] = At(tile + static_cast<long>(q) * kLane8);
  for (int i = 0; i < order; ++i) {
    const double* x = panel + static_cast<long>(i) * kLane8;
    Lane even = x[0] * rows[0], odd = x[1] * rows[1];
    for (int q = 2; q < kLane8; q += 2) {
      even += x[q] * rows[q];
      odd += x[q + 1] * rows[q + 1];
    }
    At(out + static_cast<long>(i) * kLane8) = even + odd;
  }
}

// Pairs, then fours, then eights change places.
PALPATE_DISPATCHED
void Transpose8(const double* from, int ldf, double* to, int ldt) noexcept {
  using Order = long __attribute__((vector_size(64)));
  constexpr Order kPairsLow{0, 8, 2, 10, 4, 12, 6, 14}, kPairsHigh{1, 9, 3, 11, 5, 13, 7, 15};
  constexpr Order kFoursLow{0, 1, 8, 9, 4, 5, 12, 13}, kFoursHigh{2, 3, 10, 11, 6, 7, 14, 15};
  constexpr Order kEightsLow{0, 1, 2, 3, 8, 9, 10, 11}, kEightsHigh{4, 5, 6, 7, 12, 13, 14, 15};
  Lane a[kLane8], b[kLane8];
  for (int r = 0; r < kLane8; ++r) a[r] = At(from + static_cast<long>(r) * ldf);
  for (int r = 0; r < kLane8; r += 2) {
    b[r] = __builtin_shuffle(a[r], a[r + 1], kPairsLow);
    b[r + 1] = __builtin_shuffle(a[r], a[r + 1], kPairsHigh);
  }
  for (int r = 0; r < kLane8; r += 4) {
    for (int k = 0; k < 2; ++k) {
      a[r + k] = __builtin_shuffle(b[r + k], b[r + k + 2], kFoursLow);
      a[r + k + 2] = __builtin_shuffle(b[r + k], b[r + k + 2], kFoursHigh);
    }
  }
  for (int r = 0; r < 4; ++r) {
    At(to + static_cast<long>(r) * ldt) = __builtin_shuffle(a[r], a[r + 4], kEightsLow);
    At(to + static_cast<long>(r + 4) * ldt) = __builtin_shuffle(a[r], a[r + 4], kEightsHigh);
  }
}

PALPATE_DISPATCHED
void RowDots(const double* p, int ldp, const double* r, int ldr, int order, int count,
             double* out) noexcept {
  for (int i = 0; i < order; i += 2) {
    const double* first = p + static_cast<long>(i) * ldp;
    const double* second = first + ldp;
    for (int q = 0; q < count; ++q) {
      const double* other = r + static_cast<long>(q) * ldr;
      Lane sum[2] = {};
      for (int j = 0; j < order; j += kLane8) {
        const Lane x = At(other + j);
        sum[0] += At(first + j) * x;
        sum[1] += At(second + j) * x;
      }
      for (int k = 0; k < 2; ++k) {
        out[(i + k) * kLane8 + q] = ((sum[k][0] + sum[k][1]) + (sum[k][2] + sum[k][3])) +
                                    ((sum[k][4] + sum[k][5]) + (sum[k][6] + sum[k][7]));
      }
    }
  }
}

PALPATE_DISPATCHED
void RowDot(const double* p, int ldp, const double* x, int order, double* y) noexcept {
  for (int i = 0; i < order; i += 4) {
    const double* row = p + static_cast<long>(i) * ldp;
    Lane sum[4] = {};
    for (int j = 0; j < order; j += kLane8) {
      const Lane lane = At(x + j);
      for (int k = 0; k < 4; ++k) {
        sum[k] += At(row + static_cast<long>(k) * ldp + j) * lane;
      }
    }
    for (int k = 0; k < 4; ++k) {
      y[i + k] = ((sum[k][0] + sum[k][1]) + (sum[k][2] + sum[k][3])) +
                 ((sum[k][4] + sum[k][5]) + (sum[k][6] + sum[k][7]));
    }
  }
}

PALPATE_DISPATCHED
void SubtractWide(double* c, const double* a, const double* b, int ld, int depth,
                  int width) noexcept {
  int j = 0;
  for (; j + 3 * kLane8 <= width; j += 3 * kLane8) {
    SubtractTile<kLane8, 3>(c + j, a, b + j, ld, depth);
  }
  if (width - j == 2 * kLane8) SubtractTile<kLane8, 2>(c + j, a, b + j, ld, depth);
  if (width - j == kLane8) SubtractTile<kLane8, 1>(c + j, a, b + j, ld, depth);
}

PALPATE_DISPATCHED
void SubtractTall(double* c, const double* a, const double* b, int ld, int depth,
                  int height) noexcept {
  int i = 0;
  for (; i + 2 * kLane8 <= height; i += 2 * kLane8) {
    SubtractTile<2 * kLane8, 1>(c + static_cast<long>(i) * ld, a + static_cast<long>(i) * ld, b, ld,
                                depth);
  }
  if (i < height) {
    SubtractTile<kLane8, 1>(c + static_cast<long>(i) * ld, a + static_cast<long>(i) * ld, b, ld,
                            depth);
  }
}

// Where tiles of the lower triangle are met, they are zero.
PALPATE_DISPATCHED
void SubtractByUpper(double* c, const double* a, const double* b, int ld, int width) noexcept {
  int j = 0;
  for (; j + 3 * kLane8 <= width; j += 3 * kLane8) {
    SubtractTile<kLane8, 3>(c + j, a, b + j, ld, j + 3 * kLane8);
  }
  if (width - j == 2 * kLane8) SubtractTile<kLane8, 2>(c + j, a, b + j, ld, width);
  if (width - j == kLane8) SubtractTile<kLane8, 1>(c + j, a, b + j, ld, width);
}

PALPATE_DISPATCHED
void MultiplyRight(const double* a, const double* tile, double* c, int ld, int rows) noexcept {
  Lane b[kLane8];
  for (int q = 0; q < kLane8; ++q) b[q] = At(tile + static_cast<long>(q) * kLane8);
  for (int i = 0; i < rows; ++i, a += ld, c += ld) {
    Lane even = a[0] * b[0], odd = a[1] * b[1];
    for (int q = 2; q < kLane8; q += 2) {
      even += a[q] * b[q];
      odd += a[q + 1] * b[q + 1];
    }
    At(c) = even + odd;
  }
}

PALPATE_DISPATCHED
void ThreeByThreeDots(const double* a, const double* b, int ld, int columns, double* out) noexcept {
  Lane sum[9] = {};
  for (int j = 0; j < columns; j += kLane8) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        sum[3 * r + c] +=
            At(a + static_cast<long>(r) * ld + j) * At(b + static_cast<long>(c) * ld + j);
      }
    }
  }
  for (int i = 0; i < 9; ++i) {
    out[i] = ((sum[i][0] + sum[i][1]) + (sum[i][2] + sum[i][3])) +
             ((sum[i][4] + sum[i][5]) + (sum[i][6] + sum[i][7]));
  }
}

PALPATE_DISPATCHED
void MultiplyLeft(const double* tile, double* c, int ldc, int width) noexcept {
  for (int j = 0; j < width; j += kLane8) {
    Lane rows[kLane8];
    for (int q = 0; q < kLane8; ++q) rows[q] = At(c + static_cast<long>(q) * ldc + j);
    for (int r = 0; r < kLane8; ++r) {
      const double* factors = tile + static_cast<long>(r) * kLane8;
      Lane even = factors[0] * rows[0], odd = factors[1] * rows[1];
      for (int q = 2; q < kLane8; q += 2) {
        even += factors[q] * rows[q];
        odd += factors[q + 1] * rows[q + 1];
      }
      At(c + static_cast<long>(r) * ldc + j) = even + odd;
    }
  }
}

PALPATE_DISPATCHED
void EightDots(const double* a, int lda, const double* x, int columns, double* y) noexcept {
  Lane sum[kLane8] = {};
  for (int j = 0; j < columns; j += kLane8) {
    const Lane lane = *reinterpret_cast<const LooseLane*>(x + j);
    for (int r = 0; r < kLane8; ++r) sum[r] += At(a + static_cast<long>(r) * lda + j) * lane;
  }
  for (int r = 0; r < kLane8; ++r) {
    y[r] = ((sum[r][0] + sum[r][1]) + (sum[r][2] + sum[r][3])) +
           ((sum[r][4] + sum[r][5]) + (sum[r][6] + sum[r][7]));
  }
}

// Gauss-Jordan: the column of each pivot gives way to that of the inverse. All stays in registers.
PALPATE_DISPATCHED
bool Invert8(double* a, const double* least) noexcept {
  using Mask = long __attribute__((vector_size(64)));
  constexpr Mask kNumbers{0, 1, 2, 3, 4, 5, 6, 7};
  Lane rows[kLane8];
  for (int r = 0; r < kLane8; ++r) rows[r] = At(a + static_cast<long>(r) * kLane8);
  const Lane zero = {}, one = zero + 1;
#pragma GCC unroll 8
  for (int k = 0; k < kLane8; ++k) {
    const double pivot = rows[k][k];
    if (!(pivot > least[k])) return false;
    const Mask at_pivot = kNumbers == k;
    rows[k] = (at_pivot ? one : rows[k]) * (1 / pivot);
#pragma GCC unroll 8
    for (int i = 0; i < kLane8; ++i) {
      if (i != k) rows[i] = (at_pivot ? zero : rows[i]) - rows[i][k] * rows[k];
    }
  }
  for (int r = 0; r < kLane8; ++r) At(a + static_cast<long>(r) * kLane8) = rows[r];
  return true;
}

}  // namespace palpate
