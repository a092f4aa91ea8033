#include "slave/mechanics/capacitance/dense_kernels.h"

#include <algorithm>
#include <new>

// Packages are built for baseline x86-64: the loader then takes the version that fits the machine.
// Sanitizers do not get along with such functions.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__AVX512F__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PALPATE_EVERY_MACHINE \
  __attribute__((target_clones("default", "arch=haswell", "arch=skylake-avx512")))
#else
#define PALPATE_EVERY_MACHINE
#endif

namespace palpate {
namespace {

using Lane = double __attribute__((vector_size(64), may_alias));

constexpr std::size_t kAlignment = 64;

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

PALPATE_EVERY_MACHINE
void SubtractProduct(double* c, int ldc, const double* a, const double* b, int ldb, int order,
                     int depth, bool lower) noexcept {
  for (int i = 0; i < order; i += kLane8) {
    const double* a_tile = a + static_cast<long>(i) * kLane8;
    double* c_rows = c + static_cast<long>(i) * ldc;
    const int end = lower ? i + kLane8 : order;
    for (int j = 0; j < end; j += kLane8) {
      Lane tile[kLane8];
      for (int r = 0; r < kLane8; ++r) {
        tile[r] = *reinterpret_cast<const Lane*>(c_rows + static_cast<long>(r) * ldc + j);
      }
      for (int q = 0; q < depth; ++q) {
        const Lane b_row = *reinterpret_cast<const Lane*>(b + static_cast<long>(q) * ldb + j);
        for (int r = 0; r < kLane8; ++r) tile[r] -= a_tile[r * kLane8 + q] * b_row;
      }
      for (int r = 0; r < kLane8; ++r) {
        *reinterpret_cast<Lane*>(c_rows + static_cast<long>(r) * ldc + j) = tile[r];
      }
    }
  }
}

PALPATE_EVERY_MACHINE
void RowDots(const double* p, int ldp, const double* r, int ldr, int order, int count,
             double* out) noexcept {
  for (int i = 0; i < order; i += 2) {
    const double* first = p + static_cast<long>(i) * ldp;
    const double* second = first + ldp;
    for (int q = 0; q < count; ++q) {
      const double* other = r + static_cast<long>(q) * ldr;
      Lane sum[2] = {};
      for (int j = 0; j < order; j += kLane8) {
        const Lane x = *reinterpret_cast<const Lane*>(other + j);
        sum[0] += *reinterpret_cast<const Lane*>(first + j) * x;
        sum[1] += *reinterpret_cast<const Lane*>(second + j) * x;
      }
      for (int k = 0; k < 2; ++k) {
        out[(i + k) * kLane8 + q] = ((sum[k][0] + sum[k][1]) + (sum[k][2] + sum[k][3])) +
                                    ((sum[k][4] + sum[k][5]) + (sum[k][6] + sum[k][7]));
      }
    }
  }
}

PALPATE_EVERY_MACHINE
void RowDot(const double* p, int ldp, const double* x, int order, double* y) noexcept {
  for (int i = 0; i < order; i += 4) {
    const double* row = p + static_cast<long>(i) * ldp;
    Lane sum[4] = {};
    for (int j = 0; j < order; j += kLane8) {
      const Lane lane = *reinterpret_cast<const Lane*>(x + j);
      for (int k = 0; k < 4; ++k) {
        sum[k] += *reinterpret_cast<const Lane*>(row + static_cast<long>(k) * ldp + j) * lane;
      }
    }
    for (int k = 0; k < 4; ++k) {
      y[i + k] = ((sum[k][0] + sum[k][1]) + (sum[k][2] + sum[k][3])) +
                 ((sum[k][4] + sum[k][5]) + (sum[k][6] + sum[k][7]));
    }
  }
}

// Gauss-Jordan: the column of each pivot gives way to that of the inverse.
PALPATE_EVERY_MACHINE
bool Invert8(double* a, int size, const double* least) noexcept {
  for (int k = 0; k < size; ++k) {
    double* row = a + static_cast<long>(k) * kLane8;
    const double pivot = row[k];
    if (!(pivot > least[k])) return false;
    const double by_pivot = 1 / pivot;
    row[k] = 1;
    auto& lane = *reinterpret_cast<Lane*>(row);
    lane *= by_pivot;
    for (int i = 0; i < size; ++i) {
      if (i == k) continue;
      double* other = a + static_cast<long>(i) * kLane8;
      const double factor = other[k];
      other[k] = 0;
      *reinterpret_cast<Lane*>(other) -= factor * lane;
    }
  }
  return true;
}

}  // namespace palpate
