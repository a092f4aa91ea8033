#include "slave/mechanics/fem/dense_kernels.h"

#include <algorithm>
#include <cstddef>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "slave/mechanics/fem/lanes.h"

namespace palpate::fem {
namespace {

// Small enough for Eigen to keep its copies of a tile on the stack.
constexpr int kTile = 96;

template <typename Scalar>
using Block = Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>, Eigen::Unaligned,
                         Eigen::OuterStride<>>;
template <typename Scalar>
using ConstBlock = Eigen::Map<const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>,
                              Eigen::Unaligned, Eigen::OuterStride<>>;

template <typename Scalar>
Block<Scalar> Tile(Scalar* a, int stride, int row, int column, int end_row, int end_column) {
  return {a + row + static_cast<std::ptrdiff_t>(column) * stride, std::min(kTile, end_row - row),
          std::min(kTile, end_column - column), Eigen::OuterStride<>(stride)};
}

using Float16 [[gnu::vector_size(64), gnu::may_alias]] = float;
using Doubles8 [[gnu::vector_size(64), gnu::may_alias]] = double;

PALPATE_DISPATCHED void MultiplyOf(const float* a, int stride, int columns, const float* x,
                                   float* y) {
  auto* out = reinterpret_cast<Float16*>(y);
  const int lines = stride / 16;
  for (int i = 0; i < lines; ++i) out[i] = Float16{};
  for (int j = 0; j < columns; j += 3) {  // columns come in threes
    const auto* a0 = reinterpret_cast<const Float16*>(a + static_cast<std::ptrdiff_t>(j) * stride);
    const auto* a1 = a0 + lines;
    const auto* a2 = a1 + lines;
    for (int i = 0; i < lines; ++i) out[i] += a0[i] * x[j] + a1[i] * x[j + 1] + a2[i] * x[j + 2];
  }
}

PALPATE_DISPATCHED void MultiplyOf(const double* a, int stride, int columns, const double* x,
                                   double* y) {
  auto* out = reinterpret_cast<Doubles8*>(y);
  const int lines = stride / 8;
  for (int i = 0; i < lines; ++i) out[i] = Doubles8{};
  for (int j = 0; j < columns; j += 3) {
    const auto* a0 = reinterpret_cast<const Doubles8*>(a + static_cast<std::ptrdiff_t>(j) * stride);
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

PALPATE_DISPATCHED void MultiplyTransposedOf(const float* a, int stride, int columns,
                                             const float* x, float* y) {
  const auto* in = reinterpret_cast<const Float16*>(x);
  const int lines = stride / 16;
  for (int j = 0; j < columns; j += 3) {
    const auto* a0 = reinterpret_cast<const Float16*>(a + static_cast<std::ptrdiff_t>(j) * stride);
    const auto* a1 = a0 + lines;
    const auto* a2 = a1 + lines;
    Float16 sum0{}, sum1{}, sum2{};
    for (int i = 0; i < lines; ++i) {
      sum0 += a0[i] * in[i];
      sum1 += a1[i] * in[i];
      sum2 += a2[i] * in[i];
    }
    y[j] = Sum(sum0), y[j + 1] = Sum(sum1), y[j + 2] = Sum(sum2);
  }
}

PALPATE_DISPATCHED void MultiplyTransposedOf(const double* a, int stride, int columns,
                                             const double* x, double* y) {
  const auto* in = reinterpret_cast<const Doubles8*>(x);
  const int lines = stride / 8;
  for (int j = 0; j < columns; j += 3) {
    const auto* a0 = reinterpret_cast<const Doubles8*>(a + static_cast<std::ptrdiff_t>(j) * stride);
    const auto* a1 = a0 + lines;
    const auto* a2 = a1 + lines;
    Doubles8 sum0{}, sum1{}, sum2{};
    for (int i = 0; i < lines; ++i) {
      sum0 += a0[i] * in[i];
      sum1 += a1[i] * in[i];
      sum2 += a2[i] * in[i];
    }
    y[j] = Sum(sum0), y[j + 1] = Sum(sum1), y[j + 2] = Sum(sum2);
  }
}

}  // namespace

template <typename Scalar>
bool PartialCholesky(Scalar* a, int size, int eliminated) noexcept {
  for (int j = 0; j < eliminated; j += kTile) {
    auto pivot = Tile(a, size, j, j, eliminated, eliminated);
    using Pivot =
        Eigen::Ref<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>, 0, Eigen::OuterStride<>>;
    Pivot in_place(pivot);
    const Eigen::LLT<Pivot> llt(in_place);
    if (llt.info() != Eigen::Success || !pivot.diagonal().allFinite()) return false;
    const int next = j + static_cast<int>(pivot.cols());
    for (int i = next; i < size; i += kTile) {
      auto below =
          Block<Scalar>(a + i + static_cast<std::ptrdiff_t>(j) * size, std::min(kTile, size - i),
                        pivot.cols(), Eigen::OuterStride<>(size));
      pivot.template triangularView<Eigen::Lower>()
          .transpose()
          .template solveInPlace<Eigen::OnTheRight>(below);
    }
    for (int c = next; c < size; c += kTile) {
      const ConstBlock<Scalar> right(a + c + static_cast<std::ptrdiff_t>(j) * size,
                                     std::min(kTile, size - c), pivot.cols(),
                                     Eigen::OuterStride<>(size));
      for (int r = c; r < size; r += kTile) {
        const ConstBlock<Scalar> left(a + r + static_cast<std::ptrdiff_t>(j) * size,
                                      std::min(kTile, size - r), pivot.cols(),
                                      Eigen::OuterStride<>(size));
        Tile(a, size, r, c, size, size).noalias() -= left * right.transpose();
      }
    }
  }
  return true;
}

template <typename Scalar>
void SolveFromRight(const Scalar* l, int l_stride, Scalar* b, int b_stride, int rows,
                    int columns) noexcept {
  const int last = (columns - 1) / kTile * kTile;
  for (int r = 0; r < rows; r += kTile) {
    for (int j = last; j >= 0; j -= kTile) {
      auto solved = Tile(b, b_stride, r, j, rows, columns);
      const ConstBlock<Scalar> pivot(l + j + static_cast<std::ptrdiff_t>(j) * l_stride,
                                     solved.cols(), solved.cols(), Eigen::OuterStride<>(l_stride));
      for (int i = j + kTile; i < columns; i += kTile) {
        const auto known = Tile(b, b_stride, r, i, rows, columns);
        const ConstBlock<Scalar> below(l + i + static_cast<std::ptrdiff_t>(j) * l_stride,
                                       known.cols(), solved.cols(), Eigen::OuterStride<>(l_stride));
        solved.noalias() -= known * below;
      }
      pivot.template triangularView<Eigen::Lower>().template solveInPlace<Eigen::OnTheRight>(
          solved);
    }
  }
}

// Row by row of tiles: (L L^T)^-1 = L^-T L^-1 is what solving X L^T = I, then Y L = X gives.
template <typename Scalar>
void InvertSquare(const Scalar* l, int l_stride, Scalar* inverse, int stride, int size) noexcept {
  for (int i = 0; i < size; ++i) inverse[i + static_cast<std::ptrdiff_t>(i) * stride] = Scalar(1);
  for (int r = 0; r < size; r += kTile) {
    for (int j = 0; j < size; j += kTile) {
      auto solved = Tile(inverse, stride, r, j, size, size);
      for (int i = 0; i < j; i += kTile) {
        const auto known = Tile(inverse, stride, r, i, size, size);
        const ConstBlock<Scalar> beside(l + j + static_cast<std::ptrdiff_t>(i) * l_stride,
                                        solved.cols(), known.cols(),
                                        Eigen::OuterStride<>(l_stride));
        solved.noalias() -= known * beside.transpose();
      }
      const ConstBlock<Scalar> pivot(l + j + static_cast<std::ptrdiff_t>(j) * l_stride,
                                     solved.cols(), solved.cols(), Eigen::OuterStride<>(l_stride));
      pivot.template triangularView<Eigen::Lower>()
          .transpose()
          .template solveInPlace<Eigen::OnTheRight>(solved);
    }
  }
  SolveFromRight(l, l_stride, inverse, stride, size, size);
}

template <typename Scalar>
void Multiply(const Scalar* a, int stride, int columns, const Scalar* x, Scalar* y) noexcept {
  MultiplyOf(a, stride, columns, x, y);
}

template <typename Scalar>
void MultiplyTransposed(const Scalar* a, int stride, int columns, const Scalar* x,
                        Scalar* y) noexcept {
  MultiplyTransposedOf(a, stride, columns, x, y);
}

#define PALPATE_INSTANTIATE(Scalar)                                                  \
  template bool PartialCholesky(Scalar*, int, int) noexcept;                         \
  template void SolveFromRight(const Scalar*, int, Scalar*, int, int, int) noexcept; \
  template void InvertSquare(const Scalar*, int, Scalar*, int, int) noexcept;        \
  template void Multiply(const Scalar*, int, int, const Scalar*, Scalar*) noexcept;  \
  template void MultiplyTransposed(const Scalar*, int, int, const Scalar*, Scalar*) noexcept;
PALPATE_INSTANTIATE(float)
PALPATE_INSTANTIATE(double)
#undef PALPATE_INSTANTIATE

}  // namespace palpate::fem
