// One right side through the columns of a unit lower trapezoid, for SparseLdlt alone.
//
// Ours: panels are small, and BLAS takes up to three times as long.
#pragma once

namespace palpate {

// `l`: `rows` x `columns`, the triangle first, leading dimension `rows`; its diagonal and what is
// above count as one and zero. w, `rows` long: the first `columns` become those of L^-1 w, from the
// others what is below the triangle times these is subtracted.
void SweepForward(const float* l, int rows, int columns, float* w) noexcept;
void SweepForward(const double* l, int rows, int columns, double* w) noexcept;
// The first `columns` of w become what solves L^T w' = w with the others given.
void SweepBackward(const float* l, int rows, int columns, float* w) noexcept;
void SweepBackward(const double* l, int rows, int columns, double* w) noexcept;

}  // namespace palpate
