#include "slave/mechanics/linear/sparse_ldlt.h"

#include <algorithm>
#include <cmath>

#include <cblas.h>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using MatrixMap = Eigen::Map<MatrixXd>;

constexpr int kBlock = 48;          // columns of a panel that are eliminated together
constexpr int kNarrow = 12;         // columns below which supernodes are merged freely
constexpr double kFewZeros = 0.15;  // share of stored zeros that merging may cost
constexpr double kManyZeros = 0.5;  // the same for narrow ones

}  // namespace

SparseLdlt::SparseLdlt(const Matrix& upper) : size_(static_cast<int>(upper.cols())) {
  CountColumns(upper);
  FormSupernodes();
  const Matrix lower = upper.transpose();
  FindRows(lower);
  for (const auto& s : supernodes_) {
    entries_ += Index(s.rows) * Index(s.columns);
    for (int j = 0; j < s.columns; ++j) flops_ += static_cast<double>(s.rows - j) * (s.rows - j);
  }
}

// Elimination tree and column counts by walks up the tree (Liu 1990).
void SparseLdlt::CountColumns(const Matrix& upper) {
  parent_.assign(Index(size_), -1);
  count_.assign(Index(size_), 1);
  std::vector<int> seen(Index(size_), -1);
  for (int column = 0; column < size_; ++column) {
    seen[Index(column)] = column;
    for (Matrix::InnerIterator entry(upper, column); entry; ++entry) {
      for (int i = static_cast<int>(entry.row()); seen[Index(i)] != column; i = parent_[Index(i)]) {
        if (parent_[Index(i)] < 0) parent_[Index(i)] = column;
        ++count_[Index(i)];
        seen[Index(i)] = column;
      }
    }
  }
}

void SparseLdlt::FormSupernodes() {
  struct Run {
    int first, columns, rows;
    double zeros;
  };
  std::vector<Run> runs;
  for (int j = 0; j < size_; ++j) {
    const bool joins = j > 0 && parent_[Index(j) - 1] == j &&
                       count_[Index(j) - 1] == count_[Index(j)] + 1 &&
                       runs.back().first + runs.back().columns == j;
    if (joins) {
      ++runs.back().columns;
    } else {
      runs.push_back({j, 1, count_[Index(j)], 0});
    }
  }
  // A run whose parent follows at once becomes part of it where that stores few zeros.
  std::vector<Run> merged;
  for (Run run : runs) {
    while (!merged.empty()) {
      const Run& child = merged.back();
      const int rows = child.columns + run.rows, columns = child.columns + run.columns;
      const double zeros =
          child.zeros + run.zeros + static_cast<double>(child.columns) * (rows - child.rows);
      const double share = zeros / (static_cast<double>(columns) * rows);
      const bool adjacent = parent_[Index(run.first) - 1] == run.first;
      if (!adjacent || share > (columns <= kNarrow ? kManyZeros : kFewZeros)) break;
      run = {child.first, columns, rows, zeros};
      merged.pop_back();
    }
    merged.push_back(run);
  }
  super_of_.resize(Index(size_));
  for (const auto& run : merged) {
    std::fill_n(super_of_.begin() + run.first, run.columns, static_cast<int>(supernodes_.size()));
    supernodes_.push_back({run.first, run.columns, 0, 0, 0});
  }
}

void SparseLdlt::FindRows(const Matrix& lower) {
  std::vector<int> seen(Index(size_), -1);
  std::vector<std::vector<int>> children(supernodes_.size());
  std::size_t values = 0;
  for (int k = 0; k < static_cast<int>(supernodes_.size()); ++k) {
    Supernode& s = supernodes_[Index(k)];
    s.row_at = rows_.size();
    const int end = s.first + s.columns;
    for (int j = s.first; j < end; ++j) rows_.push_back(j);
    const auto add = [&](int row) {
      if (row < end || seen[Index(row)] == k) return;
      seen[Index(row)] = k;
      rows_.push_back(row);
    };
    for (int j = s.first; j < end; ++j) {
      for (Matrix::InnerIterator entry(lower, j); entry; ++entry) {
        add(static_cast<int>(entry.row()));
      }
    }
    for (const int child : children[Index(k)]) {
      const Supernode& c = supernodes_[Index(child)];
      for (int i = c.columns; i < c.rows; ++i) add(rows_[c.row_at + Index(i)]);
    }
    std::sort(rows_.begin() + static_cast<std::ptrdiff_t>(s.row_at) + s.columns, rows_.end());
    s.rows = static_cast<int>(rows_.size() - s.row_at);
    s.value_at = values;
    values += Index(s.rows) * Index(s.columns);
    if (s.rows > s.columns) {
      children[Index(super_of_[Index(rows_[s.row_at + Index(s.columns)])])].push_back(k);
    }
  }
}

void SparseLdlt::Allocate(const Matrix& upper) {
  values_.resize(entries_);
  pivots_.resize(size_);
  place_.resize(Index(size_));
  used_.resize(supernodes_.size());
  next_.resize(supernodes_.size());
  head_.resize(supernodes_.size());
  FindDestinations(upper);
  // The largest update: rows of one supernode below, columns of another.
  std::size_t largest = 0, widest = 0;
  for (const auto& s : supernodes_) {
    const int* rows = RowsOf(s);
    widest = std::max(widest, Index(s.rows) * Index(std::max(s.columns, 1)));
    for (int i = s.columns; i < s.rows;) {
      const int target = super_of_[Index(rows[i])];
      int j = i;
      while (j < s.rows && super_of_[Index(rows[j])] == target) ++j;
      largest = std::max(largest, Index(s.rows - i) * Index(j - i));
      i = j;
    }
  }
  update_.resize(std::max<std::size_t>(largest, Index(size_)));
  scaled_.resize(widest);
}

void SparseLdlt::FindDestinations(const Matrix& upper) {
  destination_.resize(static_cast<std::size_t>(upper.nonZeros()));
  for (int column = 0; column < size_; ++column) {
    for (int k = upper.outerIndexPtr()[column]; k < upper.outerIndexPtr()[column + 1]; ++k) {
      const int row = upper.innerIndexPtr()[k];
      // Entry (column, row) of the lower triangle.
      const Supernode& s = supernodes_[Index(super_of_[Index(row)])];
      const int* rows = RowsOf(s);
      const auto place = std::lower_bound(rows, rows + s.rows, column) - rows;
      destination_[Index(k)] =
          s.value_at + Index(row - s.first) * Index(s.rows) + static_cast<std::size_t>(place);
    }
  }
}

void SparseLdlt::Link(int supernode) {
  const Supernode& s = supernodes_[Index(supernode)];
  if (used_[Index(supernode)] >= s.rows) return;
  const int target = super_of_[Index(RowsOf(s)[used_[Index(supernode)]])];
  next_[Index(supernode)] = head_[Index(target)];
  head_[Index(target)] = supernode;
}

// Subtracts from a supernode what those before it contribute.
void SparseLdlt::Gather(int target) {
  const Supernode& t = supernodes_[Index(target)];
  Panel panel = PanelOf(t);
  for (int i = 0; i < t.rows; ++i) place_[Index(RowsOf(t)[i])] = i;
  for (int source = head_[Index(target)]; source >= 0;) {
    const int following = next_[Index(source)];
    const Supernode& s = supernodes_[Index(source)];
    const int* rows = RowsOf(s);
    const int begin = used_[Index(source)];
    int end = begin;
    while (end < s.rows && rows[end] < t.first + t.columns) ++end;
    const Panel L = PanelOf(s);
    MatrixMap scaled(scaled_.data(), end - begin, s.columns);
    scaled.noalias() =
        L.middleRows(begin, end - begin) * pivots_.segment(s.first, s.columns).asDiagonal();
    MatrixMap update(update_.data(), s.rows - begin, end - begin);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, s.rows - begin, end - begin, s.columns, 1,
                &L(begin, 0), s.rows, scaled.data(), end - begin, 0, update.data(), s.rows - begin);
    for (int j = 0; j < end - begin; ++j) {
      double* column = panel.col(rows[begin + j] - t.first).data();
      for (int i = j; i < s.rows - begin; ++i)
        column[place_[Index(rows[begin + i])]] -= update(i, j);
    }
    used_[Index(source)] = end;
    Link(source);
    source = following;
  }
}

bool SparseLdlt::FactorPanel(const Supernode& s) {
  Panel A = PanelOf(s);
  for (int k = 0; k < s.columns; k += kBlock) {
    const int width = std::min(kBlock, s.columns - k);
    auto D = pivots_.segment(s.first + k, width);
    auto top = A.block(k, k, width, width);
    for (int j = 0; j < width; ++j) {
      D[j] = top(j, j);
      if (!(std::abs(D[j]) > 0) || !std::isfinite(D[j])) return false;
      top(j, j) = 1;
      for (int c = j + 1; c < width; ++c) {
        const double factor = top(c, j) / D[j];
        for (int i = c; i < width; ++i) top(i, c) -= top(i, j) * factor;
      }
      for (int i = j + 1; i < width; ++i) top(i, j) /= D[j];
    }
    const int below = s.rows - k - width;
    if (below == 0) continue;
    auto panel = A.block(k + width, k, below, width);
    cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasUnit, below, width, 1,
                &A(k, k), s.rows, &A(k + width, k), s.rows);
    MatrixMap scaled(scaled_.data(), below, width);  // L D
    scaled = panel;
    for (int j = 0; j < width; ++j) panel.col(j) /= D[j];
    for (int c = k + width; c < s.columns; c += kBlock) {
      const int wide = std::min(kBlock, s.columns - c);
      cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, s.rows - c, wide, width, -1,
                  &scaled(c - k - width, 0), below, &A(c, k), s.rows, 1, &A(c, c), s.rows);
    }
  }
  return true;
}

bool SparseLdlt::Factorize(const Matrix& upper, bool definite,
                           const std::function<bool(double)>& go_on) {
  std::fill(values_.begin(), values_.end(), 0.0);
  for (std::size_t k = 0; k < destination_.size(); ++k) {
    values_[destination_[k]] = upper.valuePtr()[k];
  }
  std::fill(head_.begin(), head_.end(), -1);
  double done = 0;
  for (int k = 0; k < static_cast<int>(supernodes_.size()); ++k) {
    Gather(k);
    const Supernode& s = supernodes_[Index(k)];
    if (!FactorPanel(s)) return false;
    done += static_cast<double>(s.rows) * s.rows * s.columns;
    if (!go_on(std::min(1.0, done / flops_))) return false;
    if (definite && pivots_.segment(s.first, s.columns).minCoeff() < 0) return false;
    used_[Index(k)] = supernodes_[Index(k)].columns;
    Link(k);
  }
  return true;
}

void SparseLdlt::Solve(VectorXd* x) {
  for (const auto& s : supernodes_) {
    const Panel L = PanelOf(s);
    const int below = s.rows - s.columns;
    const int* rows = RowsOf(s) + s.columns;
    auto own = x->segment(s.first, s.columns);
    L.topRows(s.columns).triangularView<Eigen::UnitLower>().solveInPlace(own);
    if (below == 0) continue;
    double* carried = update_.data();
    cblas_dgemv(CblasColMajor, CblasNoTrans, below, s.columns, 1, &L(s.columns, 0), s.rows,
                own.data(), 1, 0, carried, 1);
    for (int i = 0; i < below; ++i) (*x)[rows[i]] -= carried[i];
  }
  x->array() /= pivots_.array();
  for (auto s = supernodes_.rbegin(); s != supernodes_.rend(); ++s) {
    const Panel L = PanelOf(*s);
    const int below = s->rows - s->columns;
    const int* rows = RowsOf(*s) + s->columns;
    auto own = x->segment(s->first, s->columns);
    double* carried = update_.data();
    for (int i = 0; i < below; ++i) carried[i] = (*x)[rows[i]];
    if (below > 0) {
      cblas_dgemv(CblasColMajor, CblasTrans, below, s->columns, -1, &L(s->columns, 0), s->rows,
                  carried, 1, 1, own.data(), 1);
    }
    L.topRows(s->columns).triangularView<Eigen::UnitLower>().transpose().solveInPlace(own);
  }
}

}  // namespace palpate
