// Dense column-major building blocks of SparseCholesky, allocation-free. Not for use elsewhere.
//
// The products with vectors are ours: fronts are small, and BLAS takes up to three times as long.
#pragma once

namespace palpate::fem {

// The first `eliminated` columns of the lower triangle of `a` (`size` x `size`, leading dimension
// `size`) become those of its Cholesky factor, the rest its Schur complement. False: a pivot is not
// positive.
template <typename Scalar>
bool PartialCholesky(Scalar* a, int size, int eliminated) noexcept;

// b <- b L^-1, b `rows` x `columns`, L the lower triangle at `l`.
template <typename Scalar>
void SolveFromRight(const Scalar* l, int l_stride, Scalar* b, int b_stride, int rows,
                    int columns) noexcept;

// inverse <- (L L^T)^-1, `size` x `size`.
template <typename Scalar>
void InvertSquare(const Scalar* l, int l_stride, Scalar* inverse, int stride, int size) noexcept;

// y = A x and y = A^T x. The columns of A begin on 64-byte boundaries, `stride` is a multiple of
// such lines, and what is beyond the rows is zero in A (and, for the second, in x).
void Multiply(const float* a, int stride, int columns, const float* x, float* y) noexcept;
void Multiply(const double* a, int stride, int columns, const double* x, double* y) noexcept;
void MultiplyTransposed(const float* a, int stride, int columns, const float* x, float* y) noexcept;
void MultiplyTransposed(const double* a, int stride, int columns, const double* x,
                        double* y) noexcept;

}  // namespace palpate::fem
