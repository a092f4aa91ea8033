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

[[gnu::always_inline]] inline double Sum(const Lane& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

// Eight factors times eight rows, in two chains.
[[gnu::always_inline]] inline Lane Combined(const double* factors, const Lane (&rows)[kLane8]) {
  Lane even = factors[0] * rows[0], odd = factors[1] * rows[1];
  for (int q = 2; q < kLane8; q += 2) {
    even += factors[q] * rows[q];
    odd += factors[q + 1] * rows[q + 1];
  }
  return even + odd;
}

// kRows x kLanes tiles of C -= A B, that stay in registers over the whole depth.
template <int kRows, int kLanes>
[[gnu::always_inline]] inline void SubtractTile(double* c, long ldc, const double* a, long lda,
                                                const double* b, long ldb, int depth) {
  Lane sum[kRows][kLanes];
#pragma GCC unroll 24
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 3
    for (int l = 0; l < kLanes; ++l) sum[r][l] = At(c + r * ldc + l * kLane8);
  }
  for (int q = 0; q < depth; ++q, b += ldb, ++a) {
    Lane factors[kLanes];
#pragma GCC unroll 3
    for (int l = 0; l < kLanes; ++l) factors[l] = At(b + l * kLane8);
#pragma GCC unroll 24
    for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 3
      for (int l = 0; l < kLanes; ++l) sum[r][l] -= a[r * lda] * factors[l];
    }
  }
#pragma GCC unroll 24
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 3
    for (int l = 0; l < kLanes; ++l) At(c + r * ldc + l * kLane8) = sum[r][l];
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
      SubtractTile<kLane8, 2>(c_rows + j, ldc, a_tile, kLane8, b + j, ldb, depth);
    }
    if (j < end) SubtractTile<kLane8, 1>(c_rows + j, ldc, a_tile, kLane8, b + j, ldb, depth);
  }
}

PALPATE_DISPATCHED
void MultiplyPanel(const double* panel, const double* tile, int order, double* out) noexcept {
  Lane rows[kLane8];
  for (int q = 0; q < kLane8; ++q) rows[q] = At(tile + static_cast<long>(q) * kLane8);
  for (int i = 0; i < order; ++i, panel += kLane8, out += kLane8) At(out) = Combined(panel, rows);
}

// Pairs, then fours, then eights change places.
PALPATE_DISPATCHED
void Transpose8(const double* from, int ldf, double* to, int ldt) noexcept {
  Lane a[kLane8], b[kLane8];
  for (int r = 0; r < kLane8; ++r) a[r] = At(from + static_cast<long>(r) * ldf);
  for (int r = 0; r < kLane8; r += 2) {
    b[r] = __builtin_shufflevector(a[r], a[r + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    b[r + 1] = __builtin_shufflevector(a[r], a[r + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int r = 0; r < kLane8; r += 4) {
    for (int k = 0; k < 2; ++k) {
      a[r + k] = __builtin_shufflevector(b[r + k], b[r + k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      a[r + k + 2] = __builtin_shufflevector(b[r + k], b[r + k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
  for (int r = 0; r < 4; ++r) {
    At(to + static_cast<long>(r) * ldt) =
        __builtin_shufflevector(a[r], a[r + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    At(to + static_cast<long>(r + 4) * ldt) =
        __builtin_shufflevector(a[r], a[r + 4], 4, 5, 6, 7, 12, 13, 14, 15);
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
      for (int k = 0; k < 2; ++k) out[(i + k) * kLane8 + q] = Sum(sum[k]);
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
      for (int k = 0; k < 4; ++k) sum[k] += At(row + static_cast<long>(k) * ldp + j) * lane;
    }
    for (int k = 0; k < 4; ++k) y[i + k] = Sum(sum[k]);
  }
}

PALPATE_DISPATCHED
void SubtractWide(double* c, const double* a, const double* b, int ld, int depth,
                  int width) noexcept {
  int j = 0;
  for (; j + 3 * kLane8 <= width; j += 3 * kLane8) {
    SubtractTile<kLane8, 3>(c + j, ld, a, ld, b + j, ld, depth);
  }
  if (width - j == 2 * kLane8) SubtractTile<kLane8, 2>(c + j, ld, a, ld, b + j, ld, depth);
  if (width - j == kLane8) SubtractTile<kLane8, 1>(c + j, ld, a, ld, b + j, ld, depth);
}

PALPATE_DISPATCHED
void SubtractTall(double* c, const double* a, const double* b, int ld, int depth,
                  int height) noexcept {
  int i = 0;
  for (; i + 2 * kLane8 <= height; i += 2 * kLane8) {
    const long row = static_cast<long>(i) * ld;
    SubtractTile<2 * kLane8, 1>(c + row, ld, a + row, ld, b, ld, depth);
  }
  const long row = static_cast<long>(i) * ld;
  if (i < height) SubtractTile<kLane8, 1>(c + row, ld, a + row, ld, b, ld, depth);
}

// Where tiles of the lower triangle are met, they are zero.
PALPATE_DISPATCHED
void SubtractByUpper(double* c, const double* a, const double* b, int ld, int width) noexcept {
  int j = 0;
  for (; j + 3 * kLane8 <= width; j += 3 * kLane8) {
    SubtractTile<kLane8, 3>(c + j, ld, a, ld, b + j, ld, j + 3 * kLane8);
  }
  if (width - j == 2 * kLane8) SubtractTile<kLane8, 2>(c + j, ld, a, ld, b + j, ld, width);
  if (width - j == kLane8) SubtractTile<kLane8, 1>(c + j, ld, a, ld, b + j, ld, width);
}

PALPATE_DISPATCHED
void MultiplyRight(const double* a, const double* tile, double* c, int ld, int rows) noexcept {
  Lane b[kLane8];
  for (int q = 0; q < kLane8; ++q) b[q] = At(tile + static_cast<long>(q) * kLane8);
  for (int i = 0; i < rows; ++i, a += ld, c += ld) At(c) = Combined(a, b);
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
  for (int i = 0; i < 9; ++i) out[i] = Sum(sum[i]);
}

PALPATE_DISPATCHED
void MultiplyLeft(const double* tile, double* c, int ldc, int width) noexcept {
  for (int j = 0; j < width; j += kLane8) {
    Lane rows[kLane8];
    for (int q = 0; q < kLane8; ++q) rows[q] = At(c + static_cast<long>(q) * ldc + j);
    for (int r = 0; r < kLane8; ++r) {
      At(c + static_cast<long>(r) * ldc + j) = Combined(tile + static_cast<long>(r) * kLane8, rows);
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
  for (int r = 0; r < kLane8; ++r) y[r] = Sum(sum[r]);
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
