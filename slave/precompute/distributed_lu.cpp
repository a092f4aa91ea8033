#include "slave/precompute/distributed_lu.h"

#include <algorithm>
#include <array>
#include <utility>

#include "shared/geometry/index.h"
#include "slave/mechanics/linear/dense_lu.h"
#include "slave/precompute/scalapack.h"

namespace palpate {
namespace {

constexpr int kWidth = DenseLu::kWidth;
constexpr int kOne = 1;
static_assert(kWidth % DistributedLu::kBlock == 0);

}  // namespace

DistributedLu::DistributedLu(const Ranks& ranks, const ProcessGrid& grid, DistributedMatrix A)
    : ranks_(ranks),
      grid_(grid),
      alone_(1, 1),
      A_(std::move(A)),
      pivots_(static_cast<std::size_t>(A_.share().rows() + kBlock)) {
  const int n = order();
  std::vector<double> work(static_cast<std::size_t>(A_.share().cols() + kBlock));
  norm_ = pdlange_("1", &n, &n, A_.data(), &kOne, &kOne, A_.description(), work.data());
}

int DistributedLu::blocks() const {
  return (order() + kWidth - 1) / kWidth;
}

int DistributedLu::WidthOf(int block) const {
  return std::min(kWidth, order() - block * kWidth);
}

bool DistributedLu::FactorizeNext() {
  const int begin = done_ * kWidth, width = WidthOf(done_), below = order() - begin;
  if (begin > 0) TakeUpLeft(begin, width);
  // Of rows that other ranks have, ScaLAPACK leaves others in the rows to come.
  std::vector<int> pivots(pivots_.size());
  const int first = begin + 1;
  int info = 0;
  pdgetrf_(&below, &width, A_.data(), &first, &first, A_.description(), pivots.data(), &info);
  if (info != 0) return false;
  for (int row = begin; row < begin + width; ++row) {
    if (A_.HasRow(row)) pivots_[Index(A_.LocalRow(row))] = pivots[Index(A_.LocalRow(row))];
  }
  SwapRows(0, begin, begin, width);
  ++done_;
  return true;
}

std::vector<double> DistributedLu::LastBlock() {
  const int begin = (done_ - 1) * kWidth, width = WidthOf(done_ - 1);
  std::vector<int> rows(Index(width), 0);
  for (int k = 0; k < width; ++k) {
    if (A_.HasRow(begin + k)) rows[Index(k)] = pivots_[Index(A_.LocalRow(begin + k))];
  }
  ranks_.Largest(rows);
  DistributedMatrix panel(alone_, order(), width, order(), width);
  Copy(order(), width, A_, {0, begin}, &panel, {0, 0}, grid_);
  if (!ranks_.first()) return {};
  std::vector<double> block(rows.begin(), rows.end());
  block.insert(block.end(), panel.data(), panel.data() + panel.share().size());
  return block;
}

bool DistributedLu::AdoptNext(const std::vector<double>& block) {
  const int begin = done_ * kWidth, width = WidthOf(done_);
  std::vector<double> rows;
  if (ranks_.first() && block.size() == Index(width) * Index(order() + 1)) {
    rows.assign(block.begin(), block.begin() + width);
  }
  for (int k = 0; k < static_cast<int>(rows.size()); ++k) {
    if (!(rows[Index(k)] > begin + k && rows[Index(k)] <= order())) return rows.clear(), false;
  }
  ranks_.Broadcast(&rows);
  if (rows.empty()) return false;
  SetPivots(begin, rows);
  DistributedMatrix panel(alone_, order(), width, order(), width);
  if (ranks_.first()) std::copy(block.begin() + width, block.end(), panel.data());
  Copy(order(), width, panel, {0, 0}, &A_, {0, begin}, grid_);
  SwapRows(0, begin, begin, width);
  ++done_;
  return true;
}

void DistributedLu::SetPivots(int begin, const std::vector<double>& rows) {
  for (int k = 0; k < static_cast<int>(rows.size()); ++k) {
    const int row = begin + k;
    if (A_.HasRow(row)) pivots_[Index(A_.LocalRow(row))] = static_cast<int>(rows[Index(k)]);
  }
}

void DistributedLu::SolveInPlace(DistributedMatrix* B) const {
  const int n = order(), columns = B->columns();
  int info = 0;
  pdgetrs_("N", &n, &columns, A_.share().data(), &kOne, &kOne, A_.description(), pivots_.data(),
           B->data(), &kOne, &kOne, B->description(), &info);
}

double DistributedLu::ReciprocalCondition() const {
  const int n = order();
  double reciprocal = 0, size = 0;
  int int_size = 0, info = 0;
  const auto estimate = [&](double* work, int work_size, int* int_work, int int_work_size) {
    pdgecon_("1", &n, A_.share().data(), &kOne, &kOne, A_.description(), &norm_, &reciprocal, work,
             &work_size, int_work, &int_work_size, &info);
  };
  estimate(&size, -1, &int_size, -1);
  std::vector<double> work(static_cast<std::size_t>(size));
  std::vector<int> int_work(Index(int_size));
  estimate(work.data(), static_cast<int>(size), int_work.data(), int_size);
  return reciprocal;
}

// The swaps of `count` rows from `begin` on, in order.
void DistributedLu::SwapRows(int first_column, int columns, int begin, int count) {
  if (columns == 0 || count == 0) return;
  const int row = begin + 1, column = first_column + 1;
  const int* of_A = A_.description();
  const std::array<int, 9> of_pivots{of_A[0], of_A[1],      of_A[2] + kBlock * grid_.rows,
                                     1,       kBlock,       1,
                                     0,       grid_.column, static_cast<int>(pivots_.size())};
  int unused = 0;
  pdlapiv_("F", "R", "C", &count, &columns, A_.data(), &row, &column, of_A, pivots_.data(), &row,
           &kOne, of_pivots.data(), &unused);
}

void DistributedLu::TakeUpLeft(int begin, int width) {
  const int below = order() - begin, first = begin + 1;
  const double one = 1, minus_one = -1;
  const int* of_A = A_.description();
  double* A = A_.data();
  SwapRows(begin, width, 0, begin);
  pdtrsm_("L", "L", "N", "U", &begin, &width, &one, A, &kOne, &kOne, of_A, A, &kOne, &first, of_A);
  pdgemm_("N", "N", &below, &width, &begin, &minus_one, A, &first, &kOne, of_A, A, &kOne, &first,
          of_A, &one, A, &first, &first, of_A);
}

}  // namespace palpate
