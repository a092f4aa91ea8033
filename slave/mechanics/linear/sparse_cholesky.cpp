#include "slave/mechanics/linear/sparse_cholesky.h"

#include <algorithm>

#include <Eigen/Core>

#include "shared/geometry/index.h"
#include "slave/mechanics/linear/front_kernels.h"

namespace palpate::fem {

constexpr double kPenalty = 1e4;  // of a held sum, of the diagonal
constexpr int kWidest = 32;       // nodes of a front

namespace {

// Wide supernodes as chains of narrow ones: no front is a large part of the work.
std::vector<Supernode> Narrowed(const std::vector<Supernode>& wide) {
  std::vector<Supernode> narrow;
  std::vector<int> first;  // part of each
  for (const Supernode& supernode : wide) {
    first.push_back(static_cast<int>(narrow.size()));
    const int parts = (supernode.end - supernode.begin + kWidest - 1) / kWidest;
    for (int k = 0; k < parts; ++k) {
      const int count = supernode.end - supernode.begin;
      narrow.push_back({supernode.begin + k * count / parts,
                        supernode.begin + (k + 1) * count / parts,
                        static_cast<int>(narrow.size()) + 1});
    }
    narrow.back().parent = supernode.parent;
  }
  for (std::size_t s = 0; s < wide.size(); ++s) {
    const std::size_t last = s + 1 < wide.size() ? Index(first[s + 1]) - 1 : narrow.size() - 1;
    if (wide[s].parent >= 0) narrow[last].parent = first[Index(wide[s].parent)];
  }
  return narrow;
}

}  // namespace

template <typename Scalar>
SparseCholesky<Scalar>::SparseCholesky(const EliminationTree& tree, const BlockPattern& pattern)
    : pattern_(pattern), place_(Index(pattern.rows()), -1) {
  FindRows(Narrowed(tree.supernodes));
  PlacePanels();
}

template <typename Scalar>
void SparseCholesky<Scalar>::FindRows(const std::vector<Supernode>& supernodes) {
  std::vector<int> seen(Index(pattern_.rows()), -1);
  for (const auto& supernode : supernodes) {
    const int index = static_cast<int>(fronts_.size());
    Front& front = fronts_.emplace_back();
    front.begin = supernode.begin;
    front.width = supernode.end - supernode.begin;
    front.parent = supernode.parent;
    const auto add = [&](int node) {
      if (node < supernode.end || seen[Index(node)] == index) return;
      seen[Index(node)] = index;
      front.rows.push_back(node);
    };
    for (int i = supernode.begin; i < supernode.end; ++i) {
      for (const int j : pattern_.graph.of(i)) add(j);
    }
    for (int c = 0; c < index; ++c) {
      if (fronts_[Index(c)].parent == index) front.children.push_back(c);
    }
    for (const int c : front.children) {
      for (const int j : fronts_[Index(c)].rows) add(j);
    }
    std::sort(front.rows.begin(), front.rows.end());
    for (const int c : front.children) {
      for (const int j : fronts_[Index(c)].rows) {
        const auto place = std::lower_bound(front.rows.begin(), front.rows.end(), j);
        fronts_[Index(c)].into_parent.push_back(
            j < supernode.end ? j - supernode.begin
                              : front.width + static_cast<int>(place - front.rows.begin()));
      }
    }
  }
}

template <typename Scalar>
void SparseCholesky<Scalar>::PlacePanels() {
  constexpr int kLine = 64 / sizeof(Scalar);
  const auto lines = [](int rows) { return (rows + kLine - 1) / kLine; };
  std::size_t top = 0;
  update_at_.resize(fronts_.size());
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    Front& front = fronts_[f];
    const int width = 3 * front.width, height = 3 * front.height();
    front.panel = lines_;
    lines_ += Index(lines(height)) * Index(width);
    front.inverse = lines_;
    lines_ += Index(lines(width)) * Index(width);
    widest_ = std::max({widest_, lines(width), lines(height)});
    entries_ += Index(width) * (Index(height) + Index(width));
    flops_ += front.flops();
    const auto size = Index(front.size());
    stack_size_ = std::max(stack_size_, top + size * size);
    for (const int c : front.children) top = std::min(top, update_at_[Index(c)]);
    update_at_[f] = top;
    top += Index(height) * Index(height);
  }
}

template <typename Scalar>
void SparseCholesky<Scalar>::Reserve() {
  panels_ = std::make_unique_for_overwrite<Line[]>(lines_);
  stack_ = std::make_unique_for_overwrite<Scalar[]>(stack_size_);
  x_.resize(3 * Index(pattern_.rows()));
  near_.resize(Index(widest_) + 1);
  product_.resize(Index(widest_) + 1);
}

template <typename Scalar>
bool SparseCholesky<Scalar>::Factor(const BlockMatrix& matrix, double scale,
                                    const HeldComponents& held,
                                    const std::function<bool(double)>& go_on) noexcept {
  Begin();
  for (double done = 0; next_ < fronts_.size(); done += fronts_[next_ - 1].flops()) {
    if (go_on && !go_on(done / flops_)) return false;
    if (!FactorNext(matrix, scale, held)) return false;
  }
  return true;
}

template <typename Scalar>
void SparseCholesky<Scalar>::Begin() noexcept {
  next_ = top_ = 0;
}

template <typename Scalar>
typename SparseCholesky<Scalar>::Progress SparseCholesky<Scalar>::Continue(
    const BlockMatrix& matrix, double scale, const HeldComponents& held, double flops) noexcept {
  for (double done = 0; next_ < fronts_.size() && done < flops;) {
    if (!FactorNext(matrix, scale, held)) return Progress::kFailed;
    done += fronts_[next_ - 1].flops();
  }
  return next_ < fronts_.size() ? Progress::kMore : Progress::kDone;
}

template <typename Scalar>
bool SparseCholesky<Scalar>::FactorNext(const BlockMatrix& matrix, double scale,
                                        const HeldComponents& held) noexcept {
  const Front& front = fronts_[next_];
  const int size = front.size(), width = 3 * front.width, height = size - width;
  Scalar* F = stack_.get() + top_;
  std::fill_n(F, Index(size) * Index(size), Scalar(0));
  Assemble(front, matrix, scale, held, F);
  for (const int c : front.children) {
    AddUpdate(fronts_[Index(c)], stack_.get() + update_at_[Index(c)], F, size);
  }
  if (!PartialCholesky(F, size, width)) return false;
  KeepPanels(front, F);
  Scalar* update = stack_.get() + update_at_[next_];
  for (int j = 0; j < height; ++j) {  // the lower triangle, in whole blocks
    const int first = j - j % 3;
    const Scalar* from = F + width + first + Index(width + j) * Index(size);
    std::copy_n(from, height - first, update + first + Index(j) * Index(height));
  }
  top_ = update_at_[next_++] + Index(height) * Index(height);
  return true;
}

// The lower triangle of the rows and columns that are eliminated here.
template <typename Scalar>
void SparseCholesky<Scalar>::Assemble(const Front& front, const BlockMatrix& matrix, double scale,
                                      const HeldComponents& held, Scalar* F) noexcept {
  const auto size = Index(front.size());
  for (int i = 0; i < front.width; ++i) place_[Index(front.begin + i)] = i;
  for (int i = 0; i < front.height(); ++i) place_[Index(front.rows[Index(i)])] = front.width + i;
  for (int j = front.begin; j < front.begin + front.width; ++j) {
    const double* free_j = At(held.free, j).v;
    int k = pattern_.graph.begin[Index(j)];
    for (const int i : pattern_.graph.of(j)) {
      // The block at (j, i), transposed, is the one at (i, j).
      const double* block = matrix.block(k++);
      if (i < j) continue;
      const double* free_i = At(held.free, i).v;
      Scalar* to = F + 3 * Index(place_[Index(i)]) + 3 * Index(place_[Index(j)]) * size;
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t r = 0; r < 3; ++r) {
          double value = scale * block[c + 3 * r] * free_i[r] * free_j[c];
          if (i == j && r == c) value = free_i[r] > 0 ? value * (1 + held.shift) : 1;
          to[r + c * size] = static_cast<Scalar>(value);
        }
      }
    }
  }
  for (const auto& sum : held.sums) {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        const int i = sum.node[a], j = sum.node[b];
        if (j < front.begin || j >= front.begin + front.width || i < j) continue;
        if (i >= pattern_.rows()) continue;  // held wholly: it has no row, and weighs nothing
        Scalar* to = F + 3 * Index(place_[Index(i)]) + 3 * Index(place_[Index(j)]) * size;
        for (std::size_t c = 0; c < 3; ++c) {
          to[c + c * size] +=
              static_cast<Scalar>(kPenalty * sum.weight[a].v[c] * sum.weight[b].v[c]);
        }
      }
    }
  }
}

template <typename Scalar>
void SparseCholesky<Scalar>::AddUpdate(const Front& child, const Scalar* update, Scalar* F,
                                       int size) const noexcept {
  const auto height = 3 * child.rows.size();
  for (std::size_t j = 0; j < child.rows.size(); ++j) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Scalar* from = update + (3 * j + c) * height;
      Scalar* to = F + (3 * Index(child.into_parent[j]) + c) * Index(size);
      for (std::size_t i = j; i < child.rows.size(); ++i) {
        Scalar* row = to + 3 * Index(child.into_parent[i]);
        for (std::size_t r = 0; r < 3; ++r) row[r] += from[3 * i + r];
      }
    }
  }
}

template <typename Scalar>
void SparseCholesky<Scalar>::KeepPanels(const Front& front, const Scalar* F) noexcept {
  constexpr int kLine = 64 / sizeof(Scalar);
  const int size = front.size(), width = 3 * front.width, height = size - width;
  const int panel_stride = (height + kLine - 1) / kLine * kLine;
  const int inverse_stride = (width + kLine - 1) / kLine * kLine;
  Scalar* panel = at(front.panel);
  Scalar* inverse = at(front.inverse);
  std::fill_n(panel, Index(panel_stride) * Index(width), Scalar(0));
  std::fill_n(inverse, Index(inverse_stride) * Index(width), Scalar(0));
  for (int j = 0; j < width; ++j) {
    std::copy_n(F + width + Index(j) * Index(size), height, panel + Index(j) * Index(panel_stride));
  }
  SolveFromRight(F, size, panel, panel_stride, height, width);
  InvertSquare(F, size, inverse, inverse_stride, width);
}

template <typename Scalar>
void SparseCholesky<Scalar>::Solve(const NodeVector& r, NodeVector& z) noexcept {
  constexpr int kLine = 64 / sizeof(Scalar);
  const auto stride = [](int rows) { return (rows + kLine - 1) / kLine * kLine; };
  for (int i = 0; i < pattern_.rows(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) x_[3 * Index(i) + c] = static_cast<Scalar>(At(r, i).v[c]);
  }
  Scalar* near = near_.front().v;
  Scalar* product = product_.front().v;
  for (const Front& front : fronts_) {
    if (front.rows.empty()) continue;
    const int height = 3 * front.height();
    Multiply(at(front.panel), stride(height), 3 * front.width, &x_[3 * Index(front.begin)],
             product);
    for (std::size_t i = 0; i < front.rows.size(); ++i) {
      Scalar* x = &x_[3 * Index(front.rows[i])];
      for (std::size_t c = 0; c < 3; ++c) x[c] -= product[3 * i + c];
    }
  }
  for (auto f = fronts_.rbegin(); f != fronts_.rend(); ++f) {
    const int width = 3 * f->width, height = 3 * f->height();
    Scalar* x = &x_[3 * Index(f->begin)];
    Multiply(at(f->inverse), stride(width), width, x, product);
    std::copy_n(product, width, x);
    if (height == 0) continue;
    for (std::size_t i = 0; i < f->rows.size(); ++i) {
      const Scalar* from = &x_[3 * Index(f->rows[i])];
      for (std::size_t c = 0; c < 3; ++c) near[3 * i + c] = from[c];
    }
    std::fill(near + height, near + stride(height), Scalar(0));
    MultiplyTransposed(at(f->panel), stride(height), width, near, product);
    for (int i = 0; i < width; ++i) x[i] -= product[i];
  }
  for (int i = 0; i < pattern_.rows(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) At(z, i).v[c] = static_cast<double>(x_[3 * Index(i) + c]);
  }
}

template class SparseCholesky<float>;
template class SparseCholesky<double>;

}  // namespace palpate::fem
