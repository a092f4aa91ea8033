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

namespace palpate::fem {

// The cube a node is in: its corners on the coarse grid and their shares.
struct GridPlace {
  std::array<int, 8> vertex{};
  std::array<double, 8> weight{};
};

// A row whose node moves only perpendicular to the unit vector `normal`.
struct Guide {
  int row = 0;
  Eigen::Vector3d normal{0, 0, 1};
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

  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  struct alignas(16) Single {
    float v[4] = {0, 0, 0, 0};
  };

  void FindGrid(std::span<const Eigen::Vector3d> points, int most);
  bool InvertDiagonal(const BlockMatrix& A) noexcept;
  bool GuideRow(const BlockMatrix& A, const Guide& guide) noexcept;
  bool FactorCoarse(const BlockMatrix& A) noexcept;
  void CorrectCoarsely() noexcept;
  double& Coarse(int row, int column) {
    return coarse_[static_cast<std::size_t>(column) * static_cast<std::size_t>(band_ + 1) +
                   static_cast<std::size_t>(row - column)];
  }

  const BlockPattern& pattern_;
  int vertices_ = 0, band_ = 0;    // number of vertices of the coarse grid; bandwidth in unknowns
  std::vector<GridPlace> places_;  // per row
  std::vector<double> coarse_;     // lower triangle by columns, then its factor
  std::vector<double> coarse_r_;
  NodeVector coarse_nodes_;       // coarse_r_, one entry per vertex
  std::vector<int> near_, slot_;  // coarse vertices about one row
  NodeVector sums_;               // the row's products with them
  NodeVector free_, coarse_free_;
  double scale_ = 1;
  std::vector<float> values_;   // nine per block, with space for one more value
  std::vector<float> inverse_;  // values of the inverse diagonal blocks, in the same layout
  std::vector<Single> r_, z_, left_;
};

}  // namespace palpate::fem
