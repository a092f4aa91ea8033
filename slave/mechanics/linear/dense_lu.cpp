#include "slave/mechanics/linear/dense_lu.h"

#include <algorithm>
#include <utility>

#include "slave/mechanics/linear/blas.h"

// Fortran's interface, as in blas.h.
extern "C" {
void dgecon_(const char* norm, const int* n, const double* a, const int* lda, const double* norm_a,
             double* reciprocal, double* work, int* integers, int* info, std::size_t);
void dgetrf_(const int* m, const int* n, double* a, const int* lda, int* pivots, int* info);
void dgetrs_(const char* form, const int* n, const int* columns, const double* a, const int* lda,
             const int* pivots, double* b, const int* ldb, int* info, std::size_t);
void dlaswp_(const int* columns, double* a, const int* lda, const int* first, const int* last,
             const int* pivots, const int* step);
}

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
  int zero_pivot = 0;
  dgetrf_(&below, &width, &A_(begin, begin), &n, pivots, &zero_pivot);
  if (zero_pivot != 0 || !A_.middleCols(begin, width).allFinite()) return false;
  for (int k = 0; k < width; ++k) pivots[k] += begin;
  SwapRows(0, begin, begin, begin + width);
  ++done_;
  return true;
}

std::vector<double> DenseLu::LastBlock() const {
  const int begin = (done_ - 1) * kWidth;
  const int end = std::min(begin + kWidth, order());
  std::vector<double> block(swapped_.begin() + begin, swapped_.begin() + end);
  block.insert(block.end(), A_.col(begin).data(), A_.data() + Eigen::Index{end} * order());
  return block;
}

bool DenseLu::AdoptNext(const std::vector<double>& block) {
  const int begin = done_ * kWidth;
  const int end = std::min(begin + kWidth, order());
  const auto columns = static_cast<std::size_t>(std::max(0, end - begin));
  if (columns == 0 || block.size() != columns * static_cast<std::size_t>(order() + 1)) return false;
  for (std::size_t k = 0; k < columns; ++k) {
    const int row = begin + static_cast<int>(k);
    if (!(block[k] > row && block[k] <= order())) return false;
    swapped_[static_cast<std::size_t>(row)] = static_cast<int>(block[k]);
  }
  std::copy(block.begin() + end - begin, block.end(), A_.col(begin).data());
  SwapRows(0, begin, begin, end);
  ++done_;
  return true;
}

void DenseLu::SolveInPlace(Eigen::Ref<Eigen::MatrixXd> B) const {
  const int n = order(), columns = static_cast<int>(B.cols());
  const int stride = static_cast<int>(B.outerStride());
  int info = 0;
  dgetrs_("N", &n, &columns, A_.data(), &n, swapped_.data(), B.data(), &stride, &info, 1);
}

double DenseLu::ReciprocalCondition() const {
  const int n = order();
  std::vector<double> work(static_cast<std::size_t>(4 * n));
  std::vector<int> integers(static_cast<std::size_t>(n));
  double reciprocal = 0;
  int info = 0;
  dgecon_("1", &n, A_.data(), &n, &norm_, &reciprocal, work.data(), integers.data(), &info, 1);
  return reciprocal;
}

// The swaps of the columns [begin, end), in order.
void DenseLu::SwapRows(int first_column, int columns, int begin, int end) {
  const int n = order(), first = begin + 1, step = 1;
  dlaswp_(&columns, A_.col(first_column).data(), &n, &first, &end, swapped_.data(), &step);
}

// Eliminates with the columns left of `begin` in the `width` columns from there on.
void DenseLu::TakeUpLeft(int begin, int width) {
  const int n = order(), below = n - begin;
  double* top = A_.col(begin).data();
  SwapRows(begin, width, 0, begin);
  blas::Trsm('L', 'N', 'U', begin, width, A_.data(), n, top, n);
  blas::Gemm('N', 'N', below, width, begin, -1.0, &A_(begin, 0), n, top, n, 1.0, top + begin, n);
}

}  // namespace palpate
