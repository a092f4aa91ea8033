// L D L^T of a sparse symmetric matrix, not necessarily definite, in the order given and without
// pivoting: left-looking over supernodes, runs of columns with the same rows below them, so that
// most of the work is done by dense products of BLAS (Ng and Peyton 1993). In double precision, or
// in single precision for preconditioners.
//
// It is implemented here because live steps factorise repeatedly and solve a hundred times per
// factor: it does not allocate, a factor can be computed in parts, and callers do not wait for each
// other.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace palpate {

template <typename Scalar>
class SparseLdlt {
 public:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Columns = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  // The pattern of the upper triangle with its whole diagonal. Only counts: O(rows of L).
  explicit SparseLdlt(const Matrix& upper);
  [[nodiscard]] std::size_t entries() const { return entries_; }
  // Additions and multiplications of a factorisation.
  [[nodiscard]] double flops() const { return flops_; }
  // Memory after Allocate.
  [[nodiscard]] std::size_t memory_bytes() const;

  // Allocates memory for the factor. The functions below do not allocate, except for a block of
  // right-hand sides.
  void Allocate(const Matrix& upper);
  // Returns false if a pivot is zero or not finite, or negative although the matrix must be
  // `definite`, or if `go_on` stopped it, which receives the completed fraction.
  bool Factorize(
      const Matrix& upper, bool definite,
      const std::function<bool(double)>& go_on = [](double) { return true; });
  // Factorises in parts: Begin reads the values, and each Continue does `flops` of the work or a
  // little more.
  enum class Progress { kMore, kDone, kFailed };
  void Begin(const Matrix& upper, bool definite);
  Progress Continue(double flops);

  // x becomes A^-1 x.
  void Solve(Vector* x);
  // Solves for each column. The last digits depend on the number of columns that are solved
  // together.
  void Solve(Eigen::Ref<Columns> x);
  [[nodiscard]] int negative_pivots() const {
    return static_cast<int>((pivots_.array() < 0).count());
  }

 private:
  struct Supernode {
    int first = 0, columns = 0;
    int rows = 0;            // rows of the supernode, those of its own columns first
    std::size_t row_at = 0;  // in rows_
    std::size_t value_at = 0;
    double flops = 0;  // to gather and factorise it
  };
  using Panel = Eigen::Map<Columns>;
  // Right sides side by side: one column per row of the matrix.
  using Rows = Eigen::Ref<Columns>;

  void CountColumns(const Matrix& upper);
  void FormSupernodes();
  void FindRows(const Matrix& lower);
  void CountWork();
  void FindDestinations(const Matrix& upper);
  [[nodiscard]] Panel PanelOf(const Supernode& s) {
    return {values_.data() + s.value_at, s.rows, s.columns};
  }
  [[nodiscard]] const int* RowsOf(const Supernode& s) const { return rows_.data() + s.row_at; }
  // Index beyond the rows of a supernode, from `begin` on, that are columns of `target`.
  [[nodiscard]] int EndOf(const Supernode& s, int begin, const Supernode& target) const;
  bool FactorNext();
  void Gather(int target);
  void Subtract(const Supernode& source, int begin, int end, const Supernode& target);
  bool FactorPanel(const Supernode& s);
  void Link(int supernode);
  void SolveForward(const Supernode& s, Rows x);
  void SolveBackward(const Supernode& s, Rows x);

  int size_ = 0;
  std::size_t entries_ = 0;
  double flops_ = 0;
  std::vector<int> parent_, count_;  // elimination tree; entries per column, diagonal included
  std::vector<Supernode> supernodes_;
  std::vector<int> super_of_;  // per column
  std::vector<int> rows_;
  std::size_t largest_update_ = 0, largest_panel_ = 0;
  int max_rows_ = 0;                      // rows of a supernode
  std::vector<std::size_t> destination_;  // in values_, per entry of the upper triangle
  std::vector<Scalar> values_;
  Vector pivots_;
  int next_supernode_ = 0;  // next supernode for Continue
  bool definite_ = false;

  // Per supernode: how far its rows were used, and the next one that updates the same target.
  std::vector<int> used_, next_, head_;
  std::vector<int> place_;  // per row: within the target
  std::vector<Scalar> update_, scaled_;
  Columns carried_;  // part of the right sides that a panel updates
};

extern template class SparseLdlt<float>;
extern template class SparseLdlt<double>;

}  // namespace palpate
