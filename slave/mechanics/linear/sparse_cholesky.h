// Direct solution with a symmetric positive definite block matrix: a multifrontal factor
// A = L D L^T with dense blocks along the tree of separators, in single or double precision.
//
// Source: Duff and Reid (1983); the inverse of every diagonal block is kept, so that a solution
// consists of matrix-vector products only. Ours for this, for single precision and since it
// allocates nothing: a live step solves a hundred times with one factor.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "slave/mechanics/linear/block_matrix.h"

namespace palpate::fem {

// What the factor replaces in its matrix: rows and columns of components that are fixed get ones on
// the diagonal, and a weighted sum of a component that is fixed gets a penalty.
struct HeldComponents {
  struct Sum {
    int node[3] = {-1, -1, -1};
    NodeValue weight[3];  // per component
  };
  NodeVector free;        // per node and component: 1 free, 0 fixed
  std::vector<Sum> sums;  // of nodes that share an element
  double shift = 0;       // added to the diagonal, relative to it: where rigid motions are free
};

// Sizes are found on construction, memory is reserved by Reserve() and occupied by the first
// Factor; Factor and Solve are allocation-free.
template <typename Scalar>
class SparseCholesky {
 public:
  // Keeps a reference to the pattern; its nodes must be numbered by the tree. O(rows of the
  // factor).
  SparseCholesky(const EliminationTree& tree, const BlockPattern& pattern);
  void Reserve();

  // Factors scale * matrix; the scale brings its diagonal near one. False: not positive definite in
  // this precision, or stopped by `go_on`, which hears what share is done; may be empty.
  bool Factor(const BlockMatrix& matrix, double scale, const HeldComponents& held,
              const std::function<bool(double)>& go_on) noexcept;
  // The same in parts: after Begin, each Continue does `flops` of the work or a little more.
  enum class Progress { kMore, kDone, kFailed };
  void Begin() noexcept;
  Progress Continue(const BlockMatrix& matrix, double scale, const HeldComponents& held,
                    double flops) noexcept;
  // z = (scale A)^-1 r on the rows of the matrix.
  void Solve(const NodeVector& r, NodeVector& z) noexcept;

  [[nodiscard]] std::size_t entries() const { return entries_; }  // of the factor
  [[nodiscard]] double flops() const { return flops_; }           // of Factor
  [[nodiscard]] std::size_t memory_bytes() const {                // reserved by Reserve()
    return lines_ * sizeof(Line) + stack_size_ * sizeof(Scalar);
  }

 private:
  struct alignas(64) Line {
    Scalar v[64 / sizeof(Scalar)];
  };
  struct Front {
    int begin = 0, width = 0;  // nodes eliminated here
    int parent = -1;
    std::vector<int> rows;         // the nodes coupled to them that come later, rising
    std::vector<int> into_parent;  // where those stand in the parent's front
    std::vector<int> children;
    std::size_t panel = 0;    // line of U = L21 L11^-1, (3 rows) x (3 width)
    std::size_t inverse = 0;  // line of D^-1, (3 width) x (3 width)

    [[nodiscard]] int height() const { return static_cast<int>(rows.size()); }
    [[nodiscard]] int size() const { return 3 * (width + height()); }
    [[nodiscard]] double flops() const {
      const double w = 3.0 * width, h = 3.0 * height();
      return w * w * w + 2 * w * w * h + w * h * h;
    }
  };

  void FindRows(const std::vector<Supernode>& supernodes);
  void PlacePanels();
  bool FactorNext(const BlockMatrix& matrix, double scale, const HeldComponents& held) noexcept;
  void Assemble(const Front& front, const BlockMatrix& matrix, double scale,
                const HeldComponents& held, Scalar* F) noexcept;
  void AddUpdate(const Front& child, const Scalar* update, Scalar* F, int size) const noexcept;
  void KeepPanels(const Front& front, const Scalar* F) noexcept;
  [[nodiscard]] Scalar* at(std::size_t line) { return panels_[line].v; }

  const BlockPattern& pattern_;
  std::vector<Front> fronts_;
  std::vector<int> place_;  // per node, in the front being assembled
  std::unique_ptr<Line[]> panels_;
  std::unique_ptr<Scalar[]> stack_;     // fronts and update matrices during Factor
  std::vector<std::size_t> update_at_;  // per front, in stack_
  std::vector<Scalar> x_;               // three per row
  std::vector<Line> near_, product_;    // parts of x beside a panel
  std::size_t lines_ = 0, stack_size_ = 0, entries_ = 0;
  std::size_t next_ = 0, top_ = 0;  // the front that Factor goes on with; used part of stack_
  int widest_ = 0;                  // lines of the longest panel column
  double flops_ = 0;
};

extern template class SparseCholesky<float>;
extern template class SparseCholesky<double>;

}  // namespace palpate::fem
