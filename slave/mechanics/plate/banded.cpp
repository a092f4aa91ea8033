#include "slave/mechanics/plate/banded.h"

#include <algorithm>
#include <cmath>

namespace palpate::plate {

BandedSymmetric::BandedSymmetric(int size, int band)
    : size_(size),
      band_(band),
      rows_(static_cast<std::size_t>(size) * static_cast<std::size_t>(band + 1), 0.0) {}

void BandedSymmetric::SetZero() {
  std::ranges::fill(rows_, 0.0);
}

void BandedSymmetric::Hold(int i) {
  for (int j = std::max(0, i - band_); j < i; ++j) at(i, j) = 0;
  for (int k = i + 1; k < std::min(size_, i + band_ + 1); ++k) at(k, i) = 0;
  at(i, i) = 1;
}

// Row i of L D, then of L: l_ij d_j = a_ij - sum_k (l_ik d_k) l_jk.
bool BandedSymmetric::Factorise() noexcept {
  for (int i = 0; i < size_; ++i) {
    const int first = std::max(0, i - band_);
    // Indexed by column - first.
    double* row = &rows_[Place(i, first)];
    for (int j = first; j < i; ++j) {
      const int start = std::max(first, j - band_);
      const double* mine = &row[start - first];
      const double* other = &rows_[Place(j, start)];
      double sum = 0;
      for (int k = 0; k < j - start; ++k) sum += mine[k] * other[k];
      row[j - first] -= sum;
    }
    double pivot = row[i - first];
    for (int j = first; j < i; ++j) {
      const double scaled = row[j - first];
      row[j - first] /= rows_[Place(j, j)];
      pivot -= scaled * row[j - first];
    }
    if (!(std::abs(pivot) > 0) || !std::isfinite(pivot)) return false;
    row[i - first] = pivot;
  }
  return true;
}

void BandedSymmetric::Solve(Eigen::Ref<Eigen::VectorXd> x) const noexcept {
  for (int i = 0; i < size_; ++i) {
    for (int j = std::max(0, i - band_); j < i; ++j) x[i] -= rows_[Place(i, j)] * x[j];
  }
  for (int i = 0; i < size_; ++i) x[i] /= rows_[Place(i, i)];
  for (int i = size_ - 1; i >= 0; --i) {
    for (int j = std::max(0, i - band_); j < i; ++j) x[j] -= rows_[Place(i, j)] * x[i];
  }
}

}  // namespace palpate::plate
