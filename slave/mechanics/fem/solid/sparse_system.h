// The sparse symmetric system over the unknowns of a solid's nodes: order, matrix and solution.
// Nodes are in an order that keeps factors sparse, all unknowns of a node together, upper triangle
// by columns.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "slave/mechanics/fem/search_progress.h"
#include "slave/mechanics/linear/sparse_ldlt.h"
#include "slave/mechanics/tet_mesh.h"
#include "slave/mesh/index.h"

namespace palpate {

using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
constexpr int kMaxUnknowns = 34;  // of one element: ten displacements and four pressures
using ElementMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;

class BlockLayout {
 public:
  // Three displacements per node and, with `pressure`, a pressure after those of every vertex.
  // Stores a reference to the mesh. O(N log N).
  BlockLayout(const TetMesh& mesh, bool pressure);

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] bool has_pressure() const { return pressure_; }
  // Returns the positions of the nodes in the order of their unknowns.
  [[nodiscard]] std::vector<Eigen::Vector3d> Points() const;
  // First unknown of a node: x; y, z and the pressure follow.
  [[nodiscard]] int first(int node) const { return first_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] int pressure(int vertex) const { return first(vertex) + 3; }
  [[nodiscard]] int pressures() const { return pressure_ ? mesh_.vertex_count : 0; }
  // Returns the number of unknowns of the i-th node of an element.
  [[nodiscard]] int local_size(int i) const { return pressure_ && i < 4 ? 4 : 3; }
  [[nodiscard]] int element_size() const {
    return 3 * mesh_.nodes_per_element + (pressure_ ? 4 : 0);
  }

  // The pattern, all values zero.
  [[nodiscard]] const SparseMatrix& pattern() const { return pattern_; }
  // Adds an element's matrix: entry(a, i, b, k) is the entry for unknown i of node a and k of node
  // b of the element, with b >= a.
  template <typename Entry>
  void Add(int element, Entry&& entry, SparseMatrix* matrix) const {
    const auto nodes = mesh_.element(element);
    const int n = mesh_.nodes_per_element;
    const int* position = &positions_[Index(element) * Index(n * (n + 1) / 2)];
    const int* outer = matrix->outerIndexPtr();
    for (int b = 0; b < n; ++b) {
      const int first_b = first(nodes[Index(b)]), size_b = local_size(b);
      for (int a = 0; a <= b; ++a, ++position) {
        const int first_a = first(nodes[Index(a)]), size_a = local_size(a);
        double* to = matrix->valuePtr() + *position;
        if (first_a <= first_b) {
          for (int k = 0; k < size_b; ++k) {
            double* column = to + outer[first_b + k];
            for (int i = 0; i < (a == b ? k + 1 : size_a); ++i) column[i] += entry(a, i, b, k);
          }
        } else {
          for (int i = 0; i < size_a; ++i) {
            double* column = to + outer[first_a + i];
            for (int k = 0; k < size_b; ++k) column[k] += entry(a, i, b, k);
          }
        }
      }
    }
  }

 private:
  void BuildPattern(const std::vector<std::vector<int>>& upper);
  void FindPositions(const std::vector<std::vector<int>>& upper);
  [[nodiscard]] int block_size(int node) const {
    return pressure_ && node < mesh_.vertex_count ? 4 : 3;
  }

  const TetMesh& mesh_;
  bool pressure_;
  int size_ = 0;
  std::vector<int> order_;      // nodes, first to be eliminated first
  std::vector<int> rank_;       // place of a node in order_
  std::vector<int> first_;      // per node
  std::vector<int> positions_;  // per element and pair i <= j: row of the block within its column
  SparseMatrix pattern_;
};

// y = A x for the upper triangle of a symmetric A. Does not allocate if y has its size.
void Multiply(const SparseMatrix& upper, const Eigen::VectorXd& x, Eigen::VectorXd* y);

// Solves with a sparse symmetric matrix whose pattern never changes: by L D L^T, or by conjugate
// gradients on two grids where the factor is too large, or expensive and the matrix new each time.
class SymmetricSolver {
 public:
  struct Limits {
    std::size_t factor_bytes = std::size_t{2} << 30U;
    double factor_flops = 2e11;    // some tens of seconds
    double iterated_flops = 2e11;  // above this cost iterations are tried before a factor
  };
  // Analyses the pattern (upper triangle, ordered to be sparse). `points`: positions of the nodes
  // with three unknowns each; without them iterations are not used. O(entries of the factor).
  // `progress` is queried for a stop request; may be null, else it must outlive this.
  SymmetricSolver(const SparseMatrix& pattern, const Limits& limits,
                  std::span<const Eigen::Vector3d> points = {},
                  fem::SearchProgress* progress = nullptr);
  ~SymmetricSolver();

  // Rows of `fixed` unknowns are diagonal. False: a zero pivot, with `definite` a negative one, or
  // (iterative) not a definite matrix. `renew`: does not reuse data of earlier matrices.
  bool Factorize(const SparseMatrix& matrix, bool definite = false,
                 const std::vector<char>& fixed = {}, bool renew = true);
  // Sets x to A^-1 b. The matrix must be that of Factorize, unchanged. Iterations begin at x and
  // end when the true residual is below `tolerance` times b. False: no convergence.
  bool Solve(const Eigen::VectorXd& b, double tolerance, Eigen::VectorXd* x);

  [[nodiscard]] bool is_direct() const { return direct_; }
  // Iterations have met a direction of negative curvature.
  [[nodiscard]] bool indefinite() const { return indefinite_; }
  // Number of negative pivots of the last factor; -1: unknown (iterative).
  [[nodiscard]] int negative_pivots() const { return negative_pivots_; }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_; }
  // Iterations so far.
  [[nodiscard]] long iterations() const { return iterations_; }

 private:
  struct Iterative;
  bool FactorizeDirectly(const SparseMatrix& matrix, bool definite);

  fem::SearchProgress* progress_;
  bool direct_ = true, indefinite_ = false;
  int negative_pivots_ = -1;
  int worth_ = 0;  // cost of a factor in iterations; 0: not enough memory for one
  long iterations_ = 0;
  std::size_t memory_bytes_ = 0;
  const SparseMatrix* matrix_ = nullptr;  // of iterations
  std::unique_ptr<SparseLdlt<double>> factor_;
  std::unique_ptr<Iterative> iterative_;
};

}  // namespace palpate
