#include "slave/mechanics/linear/panel_sweeps.h"

#include <cstddef>

#include "slave/mechanics/linear/lanes.h"

namespace palpate {
namespace {

// Vectors of one cache line, and of four numbers.
using Floats16 [[gnu::vector_size(64)]] = float;
using Floats4 [[gnu::vector_size(16)]] = float;
using Doubles8 [[gnu::vector_size(64)]] = double;
using Doubles4 [[gnu::vector_size(32)]] = double;

constexpr int kWidth = 6;  // columns at a time

// Loads from an address of any alignment.
template <typename Line, typename Scalar>
PALPATE_INLINE Line LoadLine(const Scalar* p) {
  Line line;
  __builtin_memcpy(&line, p, sizeof(Line));
  return line;
}

// Computes y -= A x from row `i` on, in whole vectors; returns the first remaining row.
template <typename Line, int columns, typename Scalar>
PALPATE_INLINE int Subtract(const Scalar* a, int stride, int i, int rows, const Scalar* x,
                            Scalar* y) {
  constexpr int kLine = sizeof(Line) / sizeof(Scalar);
  for (; i + kLine <= rows; i += kLine) {
    auto sum = LoadLine<Line>(y + i);
    for (int c = 0; c < columns; ++c) {
      sum -= LoadLine<Line>(a + i + static_cast<std::ptrdiff_t>(c) * stride) * x[c];
    }
    __builtin_memcpy(y + i, &sum, sizeof(Line));
  }
  return i;
}

// Adds A^T y to `sums` in the same way.
template <typename Line, int columns, typename Scalar>
PALPATE_INLINE int AddProducts(const Scalar* a, int stride, int i, int rows, const Scalar* y,
                               Line* sums) {
  constexpr int kLine = sizeof(Line) / sizeof(Scalar);
  for (; i + kLine <= rows; i += kLine) {
    const auto at = LoadLine<Line>(y + i);
    for (int c = 0; c < columns; ++c) {
      sums[c] += LoadLine<Line>(a + i + static_cast<std::ptrdiff_t>(c) * stride) * at;
    }
  }
  return i;
}

template <typename Part, typename Line>
PALPATE_INLINE Part SumOfParts(const Line& line) {
  Part parts[sizeof(Line) / sizeof(Part)];
  __builtin_memcpy(parts, &line, sizeof(Line));
  Part sum = parts[0] + parts[1];
  for (std::size_t k = 2; k < sizeof(Line) / sizeof(Part); ++k) sum += parts[k];
  return sum;
}

template <typename Line, typename Part, int columns, typename Scalar>
PALPATE_INLINE void Forward(const Scalar* a, int stride, int rows, Scalar* w) {
  for (int c = 1; c < columns; ++c) {
    for (int r = 0; r < c; ++r) w[c] -= a[c + static_cast<std::ptrdiff_t>(r) * stride] * w[r];
  }
  Scalar x[columns];
  for (int c = 0; c < columns; ++c) x[c] = w[c];
  int i = Subtract<Line, columns>(a, stride, columns, rows, x, w);
  i = Subtract<Part, columns>(a, stride, i, rows, x, w);
  for (; i < rows; ++i) {
    for (int c = 0; c < columns; ++c) w[i] -= a[i + static_cast<std::ptrdiff_t>(c) * stride] * x[c];
  }
}

template <typename Line, typename Part, int columns, typename Scalar>
PALPATE_INLINE void Backward(const Scalar* a, int stride, int rows, Scalar* w) {
  Line lines[columns]{};
  int i = AddProducts<Line, columns>(a, stride, columns, rows, w, lines);
  Part parts[columns];
  for (int c = 0; c < columns; ++c) parts[c] = SumOfParts<Part>(lines[c]);
  i = AddProducts<Part, columns>(a, stride, i, rows, w, parts);
  Scalar sums[columns];
  for (int c = 0; c < columns; ++c) {
    sums[c] = (parts[c][0] + parts[c][1]) + (parts[c][2] + parts[c][3]);
  }
  for (; i < rows; ++i) {
    for (int c = 0; c < columns; ++c) {
      sums[c] += a[i + static_cast<std::ptrdiff_t>(c) * stride] * w[i];
    }
  }
  for (int c = columns - 1; c >= 0; --c) {
    w[c] -= sums[c];
    for (int r = c + 1; r < columns; ++r) {
      w[c] -= a[r + static_cast<std::ptrdiff_t>(c) * stride] * w[r];
    }
  }
}

template <typename Line, typename Part, typename Scalar>
PALPATE_INLINE void Sweep(const Scalar* l, int rows, int columns, bool forward, Scalar* w) {
  const auto step = static_cast<std::ptrdiff_t>(rows) + 1;  // down the diagonal
  const int whole = columns - columns % kWidth;
  if (forward) {
    for (int j = 0; j < whole; j += kWidth) {
      Forward<Line, Part, kWidth>(l + j * step, rows, rows - j, w + j);
    }
    for (int j = whole; j < columns; ++j) {
      Forward<Line, Part, 1>(l + j * step, rows, rows - j, w + j);
    }
  } else {
    for (int j = columns - 1; j >= whole; --j) {
      Backward<Line, Part, 1>(l + j * step, rows, rows - j, w + j);
    }
    for (int j = whole - kWidth; j >= 0; j -= kWidth) {
      Backward<Line, Part, kWidth>(l + j * step, rows, rows - j, w + j);
    }
  }
}

// clang 16 dispatches only calls within the same file.
PALPATE_DISPATCHED void InSingle(const float* l, int rows, int columns, bool forward, float* w) {
  Sweep<Floats16, Floats4>(l, rows, columns, forward, w);
}
PALPATE_DISPATCHED void InDouble(const double* l, int rows, int columns, bool forward, double* w) {
  Sweep<Doubles8, Doubles4>(l, rows, columns, forward, w);
}

}  // namespace

void SweepForward(const float* l, int rows, int columns, float* w) noexcept {
  InSingle(l, rows, columns, true, w);
}
void SweepForward(const double* l, int rows, int columns, double* w) noexcept {
  InDouble(l, rows, columns, true, w);
}
void SweepBackward(const float* l, int rows, int columns, float* w) noexcept {
  InSingle(l, rows, columns, false, w);
}
void SweepBackward(const double* l, int rows, int columns, double* w) noexcept {
  InDouble(l, rows, columns, false, w);
}

}  // namespace palpate
