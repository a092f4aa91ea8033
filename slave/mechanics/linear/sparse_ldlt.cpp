#include "slave/mechanics/linear/sparse_ldlt.h"

#include <algorithm>
#include <cmath>

#include <cblas.h>

#include "slave/mechanics/linear/panel_sweeps.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

constexpr int kBlock = 48;  // columns of a panel that are eliminated together
// Largest number of columns of a supernode, so that none is a large part of the work.
constexpr int kWidest = 96;
constexpr int kNarrow = 12;             // columns below which supernodes are merged freely
constexpr double kFewZeros = 0.15;      // share of stored zeros that merging may cost
constexpr double kManyZeros = 0.5;      // the same for narrow supernodes
constexpr Eigen::Index kTogether = 32;  // number of right-hand sides per block

// C := alpha A op(B) + beta C
void Multiply(CBLAS_TRANSPOSE form, int rows, int columns, int inner, double alpha, const double* a,
              int lda, const double* b, int ldb, double beta, double* c, int ldc) {
  cblas_dgemm(CblasColMajor, CblasNoTrans, form, rows, columns, inner, alpha, a, lda, b, ldb, beta,
              c, ldc);
}
void Multiply(CBLAS_TRANSPOSE form, int rows, int columns, int inner, float alpha, const float* a,
              int lda, const float* b, int ldb, float beta, float* c, int ldc) {
  cblas_sgemm(CblasColMajor, CblasNoTrans, form, rows, columns, inner, alpha, a, lda, b, ldb, beta,
              c, ldc);
}

// B := B op(L)^-1, L a unit lower triangle.
void DivideByUnit(CBLAS_TRANSPOSE form, int rows, int columns, const double* l, int ldl, double* b,
                  int ldb) {
  cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, form, CblasUnit, rows, columns, 1, l, ldl, b,
              ldb);
}
void DivideByUnit(CBLAS_TRANSPOSE form, int rows, int columns, const float* l, int ldl, float* b,
                  int ldb) {
  cblas_strsm(CblasColMajor, CblasRight, CblasLower, form, CblasUnit, rows, columns, 1, l, ldl, b,
              ldb);
}

// Consecutive columns with the same rows below them.
struct Run {
  int first, columns, rows;
  double zeros;
};

std::vector<Run> RunsOf(const std::vector<int>& parent, const std::vector<int>& count) {
  std::vector<Run> runs;
  for (int j = 0; j < static_cast<int>(parent.size()); ++j) {
    const bool joins = j > 0 && parent[Index(j) - 1] == j &&
                       count[Index(j) - 1] == count[Index(j)] + 1 &&
                       runs.back().first + runs.back().columns == j;
    if (joins) {
      ++runs.back().columns;
    } else {
      runs.push_back({j, 1, count[Index(j)], 0});
    }
  }
  return runs;
}

// Merges a run with its parent if the parent follows directly and few zeros are stored.
std::vector<Run> Merged(const std::vector<Run>& runs, const std::vector<int>& parent) {
  std::vector<Run> merged;
  for (Run run : runs) {
    while (!merged.empty()) {
      const Run& child = merged.back();
      const int rows = child.columns + run.rows, columns = child.columns + run.columns;
      const double zeros =
          child.zeros + run.zeros + static_cast<double>(child.columns) * (rows - child.rows);
      const double share = zeros / (static_cast<double>(columns) * rows);
      const bool adjacent = parent[Index(run.first) - 1] == run.first;
      if (!adjacent || share > (columns <= kNarrow ? kManyZeros : kFewZeros)) break;
      run = {child.first, columns, rows, zeros};
      merged.pop_back();
    }
    merged.push_back(run);
  }
  return merged;
}

}  // namespace

template <typename Scalar>
SparseLdlt<Scalar>::SparseLdlt(const Matrix& upper) : size_(static_cast<int>(upper.cols())) {
  CountColumns(upper);
  FormSupernodes();
  const Matrix lower = upper.transpose();
  FindRows(lower);
  CountWork();
}

// Computes the elimination tree and the column counts by walks up the tree (Liu 1990).
template <typename Scalar>
void SparseLdlt<Scalar>::CountColumns(const Matrix& upper) {
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

template <typename Scalar>
void SparseLdlt<Scalar>::FormSupernodes() {
  super_of_.resize(Index(size_));
  for (const Run& run : Merged(RunsOf(parent_, count_), parent_)) {
    const int parts = (run.columns + kWidest - 1) / kWidest;
    for (int k = 0; k < parts; ++k) {
      const int begin = run.first + k * run.columns / parts;
      const int columns = run.first + (k + 1) * run.columns / parts - begin;
      std::fill_n(super_of_.begin() + begin, columns, static_cast<int>(supernodes_.size()));
      supernodes_.push_back({begin, columns});
    }
  }
}

template <typename Scalar>
void SparseLdlt<Scalar>::FindRows(const Matrix& lower) {
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

// Computes the operations, and the sizes of the scratch memory.
template <typename Scalar>
void SparseLdlt<Scalar>::CountWork() {
  for (Supernode& s : supernodes_) {
    entries_ += Index(s.rows) * Index(s.columns);
    largest_panel_ = std::max(largest_panel_, Index(s.rows) * Index(std::min(s.columns, kBlock)));
    max_rows_ = std::max(max_rows_, s.rows);
    s.flops += static_cast<double>(s.rows) * s.columns * s.columns;
    for (int i = s.columns, end = i; i < s.rows; i = end) {
      Supernode& target = supernodes_[Index(super_of_[Index(RowsOf(s)[i])])];
      end = EndOf(s, i, target);
      largest_update_ = std::max(largest_update_, Index(s.rows - i) * Index(end - i));
      target.flops += 2.0 * (s.rows - i) * (end - i) * s.columns;
    }
  }
  for (const Supernode& s : supernodes_) flops_ += s.flops;
}

template <typename Scalar>
int SparseLdlt<Scalar>::EndOf(const Supernode& s, int begin, const Supernode& target) const {
  const int* rows = RowsOf(s);
  const int* end = std::lower_bound(rows + begin, rows + s.rows, target.first + target.columns);
  return static_cast<int>(end - rows);
}

template <typename Scalar>
std::size_t SparseLdlt<Scalar>::memory_bytes() const {
  const std::size_t scalars = values_.size() + update_.size() + scaled_.size();
  return sizeof(Scalar) * scalars + sizeof(std::size_t) * destination_.size() +
         sizeof(int) * (rows_.size() + 4 * Index(size_));
}

template <typename Scalar>
void SparseLdlt<Scalar>::Allocate(const Matrix& upper) {
  values_.resize(entries_);
  pivots_.resize(size_);
  place_.resize(Index(size_));
  used_.resize(supernodes_.size());
  next_.resize(supernodes_.size());
  head_.resize(supernodes_.size());
  FindDestinations(upper);
  update_.resize(std::max(largest_update_, Index(max_rows_)));
  scaled_.resize(std::max(largest_panel_, Index(kWidest * kWidest)));
}

template <typename Scalar>
void SparseLdlt<Scalar>::FindDestinations(const Matrix& upper) {
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

template <typename Scalar>
void SparseLdlt<Scalar>::Link(int supernode) {
  const Supernode& s = supernodes_[Index(supernode)];
  if (used_[Index(supernode)] >= s.rows) return;
  const int target = super_of_[Index(RowsOf(s)[used_[Index(supernode)]])];
  next_[Index(supernode)] = head_[Index(target)];
  head_[Index(target)] = supernode;
}

// Subtracts from a supernode the contributions of earlier ones.
template <typename Scalar>
void SparseLdlt<Scalar>::Gather(int target) {
  const Supernode& t = supernodes_[Index(target)];
  for (int i = 0; i < t.rows; ++i) place_[Index(RowsOf(t)[i])] = i;
  for (int source = head_[Index(target)]; source >= 0;) {
    const int following = next_[Index(source)];
    int& used = used_[Index(source)];
    const int end = EndOf(supernodes_[Index(source)], used, t);
    Subtract(supernodes_[Index(source)], used, end, t);
    used = end;
    Link(source);
    source = following;
  }
}

// Multiplies the rows of `source` from `begin` on by those up to `end`.
template <typename Scalar>
void SparseLdlt<Scalar>::Subtract(const Supernode& source, int begin, int end,
                                  const Supernode& target) {
  const Panel L = PanelOf(source);
  Panel panel = PanelOf(target);
  const int* rows = RowsOf(source) + begin;
  const int count = source.rows - begin, columns = end - begin;
  Panel scaled(scaled_.data(), columns, source.columns);
  scaled.noalias() =
      L.middleRows(begin, columns) * pivots_.segment(source.first, source.columns).asDiagonal();
  const int first = place_[Index(rows[0])];
  if (place_[Index(rows[count - 1])] - first == count - 1) {  // without gaps
    return Multiply(CblasTrans, count, columns, source.columns, -1, &L(begin, 0), source.rows,
                    scaled.data(), columns, 1, &panel(first, first), target.rows);
  }
  Panel update(update_.data(), count, columns);
  Multiply(CblasTrans, count, columns, source.columns, 1, &L(begin, 0), source.rows, scaled.data(),
           columns, 0, update.data(), count);
  for (int j = 0; j < columns; ++j) {
    Scalar* column = panel.col(rows[j] - target.first).data();
    for (int i = j; i < count; ++i) column[place_[Index(rows[i])]] -= update(i, j);
  }
}

template <typename Scalar>
bool SparseLdlt<Scalar>::FactorPanel(const Supernode& s) {
  Panel A = PanelOf(s);
  for (int k = 0; k < s.columns; k += kBlock) {
    const int width = std::min(kBlock, s.columns - k);
    auto D = pivots_.segment(s.first + k, width);
    auto top = A.block(k, k, width, width);
    for (int j = 0; j < width; ++j) {
      D[j] = top(j, j);
      if (!(std::abs(D[j]) > 0) || !std::isfinite(D[j])) return false;
      for (int c = j + 1; c < width; ++c) {
        const Scalar factor = top(c, j) / D[j];
        for (int i = c; i < width; ++i) top(i, c) -= top(i, j) * factor;
      }
      for (int i = j + 1; i < width; ++i) top(i, j) /= D[j];
    }
    const int below = s.rows - k - width;
    if (below == 0) continue;
    auto panel = A.block(k + width, k, below, width);
    DivideByUnit(CblasTrans, below, width, &A(k, k), s.rows, &A(k + width, k), s.rows);
    Panel scaled(scaled_.data(), below, width);  // L D
    scaled = panel;
    for (int j = 0; j < width; ++j) panel.col(j) /= D[j];
    for (int c = k + width; c < s.columns; c += kBlock) {
      const int wide = std::min(kBlock, s.columns - c);
      Multiply(CblasTrans, s.rows - c, wide, width, -1, &scaled(c - k - width, 0), below, &A(c, k),
               s.rows, 1, &A(c, c), s.rows);
    }
  }
  return true;
}

template <typename Scalar>
void SparseLdlt<Scalar>::Begin(const Matrix& upper, bool definite) {
  std::fill(values_.begin(), values_.end(), Scalar(0));
  for (std::size_t k = 0; k < destination_.size(); ++k) {
    values_[destination_[k]] = static_cast<Scalar>(upper.valuePtr()[k]);
  }
  std::fill(head_.begin(), head_.end(), -1);
  next_supernode_ = 0;
  definite_ = definite;
}

template <typename Scalar>
bool SparseLdlt<Scalar>::FactorNext() {
  const int k = next_supernode_++;
  Gather(k);
  const Supernode& s = supernodes_[Index(k)];
  if (!FactorPanel(s)) return false;
  if (definite_ && pivots_.segment(s.first, s.columns).minCoeff() < 0) return false;
  used_[Index(k)] = s.columns;
  Link(k);
  return true;
}

template <typename Scalar>
typename SparseLdlt<Scalar>::Progress SparseLdlt<Scalar>::Continue(double flops) {
  const int count = static_cast<int>(supernodes_.size());
  for (double done = 0; next_supernode_ < count && done < flops;) {
    done += supernodes_[Index(next_supernode_)].flops;
    if (!FactorNext()) return Progress::kFailed;
  }
  return next_supernode_ < count ? Progress::kMore : Progress::kDone;
}

template <typename Scalar>
bool SparseLdlt<Scalar>::Factorize(const Matrix& upper, bool definite,
                                   const std::function<bool(double)>& go_on) {
  Begin(upper, definite);
  double done = 0;
  for (const Supernode& s : supernodes_) {
    if (!FactorNext()) return false;
    done += s.flops;
    if (!go_on(std::min(1.0, done / flops_))) return false;
  }
  return true;
}

template <typename Scalar>
void SparseLdlt<Scalar>::Solve(Vector* x) {
  Scalar* w = update_.data();
  for (const auto& s : supernodes_) {
    const int* rows = RowsOf(s);
    Scalar* own = x->data() + s.first;
    std::copy_n(own, s.columns, w);
    std::fill(w + s.columns, w + s.rows, Scalar(0));
    SweepForward(PanelOf(s).data(), s.rows, s.columns, w);
    std::copy_n(w, s.columns, own);
    for (int i = s.columns; i < s.rows; ++i) (*x)[rows[i]] += w[i];
  }
  x->array() /= pivots_.array();
  for (auto s = supernodes_.rbegin(); s != supernodes_.rend(); ++s) {
    const int* rows = RowsOf(*s);
    for (int i = 0; i < s->rows; ++i) w[i] = (*x)[rows[i]];
    SweepBackward(PanelOf(*s).data(), s->rows, s->columns, w);
    std::copy_n(w, s->columns, x->data() + s->first);
  }
}

template <typename Scalar>
void SparseLdlt<Scalar>::Solve(Eigen::Ref<Columns> x) {
  for (Eigen::Index first = 0; first < x.cols(); first += kTogether) {
    auto part = x.middleCols(first, std::min(kTogether, x.cols() - first));
    Columns rows = part.transpose();
    carried_.resize(rows.rows(), max_rows_);
    for (const auto& s : supernodes_) SolveForward(s, rows);
    rows.array().rowwise() /= pivots_.array().transpose();
    for (auto s = supernodes_.rbegin(); s != supernodes_.rend(); ++s) SolveBackward(*s, rows);
    part = rows.transpose();
  }
}

template <typename Scalar>
void SparseLdlt<Scalar>::SolveForward(const Supernode& s, Rows x) {
  auto own = x.middleCols(s.first, s.columns);
  if (own.isZero(0)) return;  // most are zero if only few nodes are loaded
  const Panel L = PanelOf(s);
  const int count = static_cast<int>(x.rows()), below = s.rows - s.columns;
  const int* rows = RowsOf(s) + s.columns;
  DivideByUnit(CblasTrans, count, s.columns, L.data(), s.rows, own.data(), count);
  if (below == 0) return;
  Multiply(CblasTrans, count, below, s.columns, 1, own.data(), count, &L(s.columns, 0), s.rows, 0,
           carried_.data(), count);
  for (int i = 0; i < below; ++i) x.col(rows[i]) -= carried_.col(i);
}

template <typename Scalar>
void SparseLdlt<Scalar>::SolveBackward(const Supernode& s, Rows x) {
  auto own = x.middleCols(s.first, s.columns);
  const Panel L = PanelOf(s);
  const int count = static_cast<int>(x.rows()), below = s.rows - s.columns;
  const int* rows = RowsOf(s) + s.columns;
  for (int i = 0; i < below; ++i) carried_.col(i) = x.col(rows[i]);
  if (below > 0) {
    Multiply(CblasNoTrans, count, s.columns, below, -1, carried_.data(), count, &L(s.columns, 0),
             s.rows, 1, own.data(), count);
  }
  DivideByUnit(CblasNoTrans, count, s.columns, L.data(), s.rows, own.data(), count);
}

template class SparseLdlt<float>;
template class SparseLdlt<double>;

}  // namespace palpate
