#include "slave/mechanics/linear/dense_lu.h"

#include <algorithm>
#include <utility>

#include <cblas.h>
#include <lapacke.h>

namespace palpate {

DenseLu::DenseLu(Eigen::MatrixXd A)
    : A_(std::move(A)),
      norm_(A_.cwiseAbs().colwise().sum().maxCoeff()),
      swapped_(static_cast<std::size_t>(order())) {}

bool DenseLu::FactorizeNext() {
  const int begin = done_ * kWidth, n = order();
  const int width = std::min(kWidth, n - begin), below = n - begin;
  if (begin > 0) TakeUpLeft(begin, width);
  int* pivots = swapped_.data() + begin;
  const int zero_pivot =
      LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, below, width, &A_(begin, begin), n, pivots);
  if (zero_pivot != 0 || !A_.middleCols(begin, width).allFinite()) return false;
  for (int k = 0; k < width; ++k) pivots[k] += begin;
  SwapRows(0, begin, begin, begin + width);
  ++done_;
  return true;
}

void DenseLu::SolveInPlace(Eigen::Ref<Eigen::MatrixXd> B) const {
  const int n = order();
  LAPACKE_dgetrs_work(LAPACK_COL_MAJOR, 'N', n, static_cast<int>(B.cols()), A_.data(), n,
                      swapped_.data(), B.data(), static_cast<int>(B.outerStride()));
}

double DenseLu::ReciprocalCondition() const {
  double reciprocal = 0;
  LAPACKE_dgecon(LAPACK_COL_MAJOR, '1', order(), A_.data(), order(), norm_, &reciprocal);
  return reciprocal;
}

// Applies the row swaps of the columns [begin, end), in order.
void DenseLu::SwapRows(int first_column, int columns, int begin, int end) {
  LAPACKE_dlaswp_work(LAPACK_COL_MAJOR, columns, A_.col(first_column).data(), order(), begin + 1,
                      end, swapped_.data(), 1);
}

// Applies the elimination of the columns left of `begin` to the `width` columns from there on.
void DenseLu::TakeUpLeft(int begin, int width) {
  const int n = order(), below = n - begin;
  double* top = A_.col(begin).data();
  SwapRows(begin, width, 0, begin);
  cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasUnit, begin, width, 1,
              A_.data(), n, top, n);
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, below, width, begin, -1, &A_(begin, 0), n,
              top, n, 1, top + begin, n);
}

}  // namespace palpate
