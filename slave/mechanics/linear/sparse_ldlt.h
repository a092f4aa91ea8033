// L D L^T of a sparse symmetric matrix, not necessarily definite, in the order given and without
// pivoting: left-looking over supernodes, runs of columns with the same rows below them, so that
// most of the work is done by dense products of BLAS (Ng and Peyton 1993).
//
// Ours because live steps factorise again and again: with the same BLAS it takes 0.3 to 0.9 of
// MUMPS' time (bench_linear), and MUMPS works for one caller of the process at a time.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace palpate {

class SparseLdlt {
 public:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

  // Of the upper triangle with its whole diagonal. Only counts: O(entries of L).
  explicit SparseLdlt(const Matrix& upper);
  [[nodiscard]] std::size_t entries() const { return entries_; }
  [[nodiscard]] double flops() const { return flops_; }

  // Takes memory for the factor.
  void Allocate(const Matrix& upper);
  // False: a pivot is zero or not finite, or negative where the matrix must be `definite`; or
  // stopped by `go_on`, which hears what share is done. Does not allocate.
  bool Factorize(
      const Matrix& upper, bool definite,
      const std::function<bool(double)>& go_on = [](double) { return true; });
  // x becomes A^-1 x. Does not allocate.
  void Solve(Eigen::VectorXd* x);
  [[nodiscard]] int negative_pivots() const {
    return static_cast<int>((pivots_.array() < 0).count());
  }

 private:
  struct Supernode {
    int first = 0, columns = 0;
    int rows = 0;            // its own columns first
    std::size_t row_at = 0;  // in rows_
    std::size_t value_at = 0;
  };
  using Panel = Eigen::Map<Eigen::MatrixXd>;

  void CountColumns(const Matrix& upper);
  void FormSupernodes();
  void FindRows(const Matrix& lower);
  void FindDestinations(const Matrix& upper);
  [[nodiscard]] Panel PanelOf(const Supernode& s) {
    return {values_.data() + s.value_at, s.rows, s.columns};
  }
  [[nodiscard]] const int* RowsOf(const Supernode& s) const { return rows_.data() + s.row_at; }
  void Gather(int target);
  bool FactorPanel(const Supernode& s);
  void Link(int supernode);

  int size_ = 0;
  std::size_t entries_ = 0;
  double flops_ = 0;
  std::vector<int> parent_, count_;  // elimination tree; entries per column, diagonal included
  std::vector<Supernode> supernodes_;
  std::vector<int> super_of_;  // per column
  std::vector<int> rows_;
  std::vector<std::size_t> destination_;  // in values_, per entry of the upper triangle
  std::vector<double> values_;
  Eigen::VectorXd pivots_;

  // Per supernode: how far its rows were used, and the next one that updates the same target.
  std::vector<int> used_, next_, head_;
  std::vector<int> place_;  // per row: within the target
  std::vector<double> update_, scaled_;
};

}  // namespace palpate
