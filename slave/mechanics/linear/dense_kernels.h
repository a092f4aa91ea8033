// Inner loops on dense row-major matrices, eight doubles at a time. Every pointer is aligned to 64
// bytes, every leading dimension and count of rows or columns is a multiple of kLane8.
#pragma once

#include <memory>

namespace palpate {

constexpr int kLane8 = 8;
constexpr int PaddedTo8(int n) {
  return (n + kLane8 - 1) / kLane8 * kLane8;
}

struct AlignedFree {
  void operator()(double* memory) const noexcept;
};
using AlignedArray = std::unique_ptr<double[], AlignedFree>;
// Zeros. Throws std::bad_alloc.
AlignedArray MakeAligned(std::size_t count);

// C -= A B: A is order x depth with leading dimension kLane8, B depth x order, depth <= kLane8.
// `lower`: tiles above the diagonal stay as they are.
void SubtractProduct(double* c, int ldc, const double* a, const double* b, int ldb, int order,
                     int depth, bool lower) noexcept;

// out(i, q) = row i of P times row q of R, q < count <= kLane8; `out` has leading dimension kLane8.
void RowDots(const double* p, int ldp, const double* r, int ldr, int order, int count,
             double* out) noexcept;

// C -= A B, all with the same leading dimension: A is kLane8 x depth, B depth x width.
void SubtractWide(double* c, const double* a, const double* b, int ld, int depth,
                  int width) noexcept;
// The same for A height x depth and B depth x kLane8.
void SubtractTall(double* c, const double* a, const double* b, int ld, int depth,
                  int height) noexcept;
// C -= A B, where B is upper triangular in tiles, width x width, and A kLane8 x width.
void SubtractByUpper(double* c, const double* a, const double* b, int ld, int width) noexcept;
// C = A times tile, where A and C are rows x kLane8 with leading dimension `ld`.
void MultiplyRight(const double* a, const double* tile, double* c, int ld, int rows) noexcept;
// out = A B^T for three rows each; `out` is row-major.
void ThreeByThreeDots(const double* a, const double* b, int ld, int columns, double* out) noexcept;
// C = tile times C: the tile has leading dimension kLane8, C kLane8 rows.
void MultiplyLeft(const double* tile, double* c, int ldc, int width) noexcept;
// y = A x for kLane8 rows of A; x and y may lie anywhere.
void EightDots(const double* a, int lda, const double* x, int columns, double* y) noexcept;

// y = P x.
void RowDot(const double* p, int ldp, const double* x, int order, double* y) noexcept;

// out = panel (order x 8) times an 8 x 8 tile; leading dimensions kLane8.
void MultiplyPanel(const double* panel, const double* tile, int order, double* out) noexcept;

// An 8 x 8 tile, transposed.
void Transpose8(const double* from, int ldf, double* to, int ldt) noexcept;

// Inverts an 8 x 8 matrix (leading dimension kLane8) in place, without pivoting. Pivot i must
// exceed `least[i]`, else false and the matrix stays.
bool Invert8(double* a, const double* least) noexcept;

}  // namespace palpate
