// Preconditioner of elastic bodies: one cycle of two grids. A sweep of block Gauss and Seidel, a
// correction from a regular grid of cubes about the body, whose trilinear displacements are solved
// for exactly, and the same sweep backwards: symmetric, hence fit for conjugate gradients.
//
// Sources: Brandt (1977) for the two grids; Griebel and Schweitzer (2002) for a coarse space that
// is independent of the mesh. Sweeps are in single precision, the coarse grid in double.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/grouped_matrix.h"

namespace palpate::fem {

// The cube a node is in: its corners on the coarse grid and their shares.
struct GridPlace {
  std::array<int, 8> vertex{};
  std::array<float, 8> weight{};
};

// A node of the fine grid in a cube.
struct CubeNode {
  int row = 0;
  int place = 0;           // in a vector of the fine grid's matrix
  float t[3] = {0, 0, 0};  // coordinates in the cube [0, 1]
};

class TwoGrid {
 public:
  // `points`: positions of the pattern's rows. Stores a reference to the pattern. O(N log N).
  TwoGrid(std::span<const Eigen::Vector3d> points, const BlockPattern& pattern);

  // `free` per row and component: 1 free, 0 fixed. Rows and columns of fixed components, and of the
  // normals of `guides` (except on the coarse grid), are treated as those of the identity. False:
  // not positive definite. Allocation-free.
  bool Factor(const BlockMatrix& A, const NodeVector& free,
              std::span<const Guide> guides = {}) noexcept;
  // Factors with the coarse grid of the last Factor, which suits similar matrices and other fixed
  // components.
  bool Renew(const BlockMatrix& A, const NodeVector& free, std::span<const Guide> guides) noexcept;
  // Returns whether the last Factor fixed all components that `free` fixes.
  [[nodiscard]] bool CoarseFixes(const NodeVector& free) const noexcept;
  // z = M^-1 r on the free components of the pattern's rows, zero elsewhere. Allocation-free.
  void Solve(const NodeVector& r, NodeVector& z) noexcept;

  // Conjugate gradients in single precision, with the matrix of the last Factor or Renew as A:
  // what the sweeps know spares the product. Residuals are right to 1e-6 of the first one.
  // Allocation-free.
  //
  // Begins with the residual `r`, which is zero where nothing is free.
  void Begin(const NodeVector& r) noexcept;
  // One iteration. Returns what must be positive: the direction's curvature, or by rounding or an
  // indefinite matrix r . M^-1 r; else nothing has changed.
  double Iterate() noexcept;
  [[nodiscard]] double residual() const { return size_ * left_share_; }  // its norm
  // r = the residual, x += the solution.
  void End(NodeVector& r, NodeVector& x) const noexcept;

  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  void FindGrid(std::span<const Eigen::Vector3d> points, int most);
  bool FactorCoarse(const BlockMatrix& A) noexcept;
  void Take(const NodeVector& r) noexcept;
  void AddTo(const GroupedMatrix::Vector& x, double factor, NodeVector& y) const noexcept;
  void Cycle() noexcept;
  void KeepCoarse() noexcept;
  void CorrectCoarsely() noexcept;
  double& Coarse(int row, int column) {
    return coarse_[static_cast<std::size_t>(column) * static_cast<std::size_t>(band_ + 1) +
                   static_cast<std::size_t>(row - column)];
  }

  const BlockPattern& pattern_;
  int vertices_ = 0, band_ = 0;    // number of vertices of the coarse grid; bandwidth in unknowns
  std::vector<GridPlace> places_;  // per row
  std::vector<double> coarse_;     // lower triangle by columns, then its factor
  // The factor in single precision: the diagonal's inverse, and `width_` numbers below it.
  int width_ = 0;
  std::vector<float> inverse_, below_, coarse_x_;
  std::vector<int> cube_begin_;
  std::vector<std::array<int, 8>> cube_vertices_;
  std::vector<CubeNode> cube_nodes_;
  std::vector<int> cube_rows_;
  std::vector<int> near_, slot_;          // coarse vertices about one cube
  std::vector<Float16> row_sums_, sums_;  // products with them: a row's, and of the cube's corners
  std::vector<char> is_used_;
  NodeVector free_, coarse_free_;
  double scale_ = 1;
  GroupedMatrix fine_;
  double size_ = 0;                                  // of the residual that was given
  GroupedMatrix::Vector r_;                          // by that size
  GroupedMatrix::Vector z_, left_, rest_, product_;  // of a cycle
  GroupedMatrix::Vector x_, p_, q_;
  double left_share_ = 1, rho_ = 0;
};

}  // namespace palpate::fem
