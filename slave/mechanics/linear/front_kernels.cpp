#include "slave/mechanics/linear/front_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include <cblas.h>
#include <lapacke.h>

#include "slave/mechanics/linear/lanes.h"

namespace palpate::fem {
namespace {

// A cache line of numbers.
using Float16 [[gnu::vector_size(64), gnu::may_alias]] = float;
using Doubles8 [[gnu::vector_size(64), gnu::may_alias]] = double;

template <typename Scalar, typename Single, typename Double>
constexpr auto Pick(Single* in_single, Double* in_double) {
  if constexpr (std::is_same_v<Scalar, float>) {
    return in_single;
  } else {
    return in_double;
  }
}

// B := B op(L)^-1, B `rows` x `columns`, L a lower triangle.
template <typename Scalar>
void SolveTriangle(CBLAS_TRANSPOSE form, const Scalar* l, int l_stride, Scalar* b, int b_stride,
                   int rows, int columns) {
  Pick<Scalar>(cblas_strsm, cblas_dtrsm)(CblasColMajor, CblasRight, CblasLower, form, CblasNonUnit,
                                         rows, columns, 1, l, l_stride, b, b_stride);
}

template <typename Line, typename Scalar>
PALPATE_INLINE void MultiplyLines(const Scalar* a, int stride, int columns, const Scalar* x,
                                  Scalar* y) {
  auto* out = reinterpret_cast<Line*>(y);
  const int lines = stride / static_cast<int>(sizeof(Line) / sizeof(Scalar));
  for (int i = 0; i < lines; ++i) out[i] = Line{};
  for (int j = 0; j < columns; j += 3) {  // columns come in threes
    const auto* a0 = reinterpret_cast<const Line*>(a + static_cast<std::ptrdiff_t>(j) * stride);
    const auto* a1 = a0 + lines;
    const auto* a2 = a1 + lines;
    for (int i = 0; i < lines; ++i) out[i] += a0[i] * x[j] + a1[i] * x[j + 1] + a2[i] * x[j + 2];
  }
}

PALPATE_INLINE float Sum(const Float16& v) {
  float sum[8];
  for (int l = 0; l < 8; ++l) sum[l] = v[l] + v[l + 8];
  return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}
PALPATE_INLINE double Sum(const Doubles8& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

template <typename Line, typename Scalar>
PALPATE_INLINE void MultiplyLinesTransposed(const Scalar* a, int stride, int columns,
                                            const Scalar* x, Scalar* y) {
  const auto* in = reinterpret_cast<const Line*>(x);
  const int lines = stride / static_cast<int>(sizeof(Line) / sizeof(Scalar));
  for (int j = 0; j < columns; j += 3) {
    const auto* a0 = reinterpret_cast<const Line*>(a + static_cast<std::ptrdiff_t>(j) * stride);
    const auto* a1 = a0 + lines;
    const auto* a2 = a1 + lines;
    Line sum0{}, sum1{}, sum2{};
    for (int i = 0; i < lines; ++i) {
      sum0 += a0[i] * in[i];
      sum1 += a1[i] * in[i];
      sum2 += a2[i] * in[i];
    }
    y[j] = Sum(sum0), y[j + 1] = Sum(sum1), y[j + 2] = Sum(sum2);
  }
}

}  // namespace

PALPATE_DISPATCHED void Multiply(const float* a, int stride, int columns, const float* x,
                                 float* y) noexcept {
  MultiplyLines<Float16>(a, stride, columns, x, y);
}
PALPATE_DISPATCHED void Multiply(const double* a, int stride, int columns, const double* x,
                                 double* y) noexcept {
  MultiplyLines<Doubles8>(a, stride, columns, x, y);
}
PALPATE_DISPATCHED void MultiplyTransposed(const float* a, int stride, int columns, const float* x,
                                           float* y) noexcept {
  MultiplyLinesTransposed<Float16>(a, stride, columns, x, y);
}
PALPATE_DISPATCHED void MultiplyTransposed(const double* a, int stride, int columns,
                                           const double* x, double* y) noexcept {
  MultiplyLinesTransposed<Doubles8>(a, stride, columns, x, y);
}

template <typename Scalar>
bool PartialCholesky(Scalar* a, int size, int eliminated) noexcept {
  const auto factor = Pick<Scalar>(LAPACKE_spotrf_work, LAPACKE_dpotrf_work);
  if (factor(LAPACK_COL_MAJOR, 'L', eliminated, a, size) != 0) return false;
  for (int j = 0; j < eliminated; ++j) {
    if (!std::isfinite(a[j + static_cast<std::ptrdiff_t>(j) * size])) return false;
  }
  const int rest = size - eliminated;
  if (rest == 0) return true;
  Scalar* below = a + eliminated;
  SolveTriangle(CblasTrans, a, size, below, size, rest, eliminated);
  Pick<Scalar>(cblas_ssyrk, cblas_dsyrk)(
      CblasColMajor, CblasLower, CblasNoTrans, rest, eliminated, -1, below, size, 1,
      below + static_cast<std::ptrdiff_t>(eliminated) * size, size);
  return true;
}

template <typename Scalar>
void SolveFromRight(const Scalar* l, int l_stride, Scalar* b, int b_stride, int rows,
                    int columns) noexcept {
  if (rows == 0) return;  // a root; BLAS complains of its stride
  SolveTriangle(CblasNoTrans, l, l_stride, b, b_stride, rows, columns);
}

template <typename Scalar>
void InvertSquare(const Scalar* l, int l_stride, Scalar* inverse, int stride, int size) noexcept {
  const auto column = [&](int j) { return inverse + static_cast<std::ptrdiff_t>(j) * stride; };
  for (int j = 0; j < size; ++j) {
    const Scalar* from = l + static_cast<std::ptrdiff_t>(j) * l_stride;
    std::copy(from + j, from + size, column(j) + j);
  }
  Pick<Scalar>(LAPACKE_spotri_work, LAPACKE_dpotri_work)(LAPACK_COL_MAJOR, 'L', size, inverse,
                                                         stride);
  for (int j = 0; j < size; ++j) {
    for (int i = 0; i < j; ++i) column(j)[i] = column(i)[j];
  }
}

#define PALPATE_INSTANTIATE(Scalar)                                                  \
  template bool PartialCholesky(Scalar*, int, int) noexcept;                         \
  template void SolveFromRight(const Scalar*, int, Scalar*, int, int, int) noexcept; \
  template void InvertSquare(const Scalar*, int, Scalar*, int, int) noexcept;
PALPATE_INSTANTIATE(float)
PALPATE_INSTANTIATE(double)
#undef PALPATE_INSTANTIATE

}  // namespace palpate::fem
