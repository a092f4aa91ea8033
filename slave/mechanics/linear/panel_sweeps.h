// Triangular solves of one right-hand side with a unit lower trapezoidal panel, for SparseLdlt.
//
// BLAS takes up to three times as long for such small panels.
#pragma once

namespace palpate {

// `l`: `rows` x `columns`, the triangle first, leading dimension `rows`; its diagonal is taken as
// one, the entries above as zero. w has `rows` entries: the first `columns` become those of L^-1 w;
// from the others the panel's lower part times these is subtracted.
void SweepForward(const float* l, int rows, int columns, float* w) noexcept;
void SweepForward(const double* l, int rows, int columns, double* w) noexcept;
// Replaces the first `columns` entries of w by the solution of L^T w' = w for given other entries.
void SweepBackward(const float* l, int rows, int columns, float* w) noexcept;
void SweepBackward(const double* l, int rows, int columns, double* w) noexcept;

}  // namespace palpate
