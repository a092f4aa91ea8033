// A symmetric matrix of 3 x 3 blocks in single precision, for sweeps of block Gauss and Seidel.
//
// Rows are sorted by colours, so that no two of a colour are neighbours, and by their lengths, and
// are swept four at a time: what one row needs of the one before it is computed long before. Only
// the blocks right of the diagonal are kept, which fit in a processor's cache twice as often as the
// whole matrix; the others are their transposes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/lanes.h"

namespace palpate::fem {

// A row whose node moves across `normal` only, unit.
struct Guide {
  int row = 0;
  Eigen::Vector3d normal{0, 0, 1};
};

class GroupedMatrix {
 public:
  // Four rows: x, y, z and a zero of each.
  using Group = Float16;
  // In the matrix's own order; the rows of its last group are no rows and stay zero.
  using Vector = std::vector<Group>;

  // Keeps a reference to the pattern. All blocks are zero.
  explicit GroupedMatrix(const BlockPattern& pattern);

  // scale * A. `free` per row and component: 1 free, 0 fixed; a row of `guides` is fixed along its
  // normal. False: a block of the diagonal is not positive definite. Allocation-free.
  bool Set(const BlockMatrix& A, double scale, const NodeVector& free,
           std::span<const Guide> guides) noexcept;

  // The following four are A = L + D + L^T among what is free. Vectors may hold anything elsewhere.
  //
  // Solves (L + D) z = r, replaces r by D z, and computes what remains: left = -L^T z.
  void SweepForward(Vector* r, Vector* z, Vector* left) const noexcept;
  // Replaces what is not free in x by zero.
  void Restrict(Vector* x) const noexcept;
  // y -= L x
  void SubtractLower(const Vector& x, Vector* y) const noexcept;
  // Solves (D + L^T) z = r, and adds L times the change of z to y.
  void SweepBackward(const Vector& r, Vector* z, Vector* y) const noexcept;

  // Where a row is in a Vector taken as numbers.
  [[nodiscard]] std::size_t Place(int row) const {
    return 4 * static_cast<std::size_t>(position_[static_cast<std::size_t>(row)]);
  }
  [[nodiscard]] Vector MakeVector() const { return Vector(inverse_.size() + 1); }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  using Three = std::array<Group, 3>;

  void Sort();
  bool Invert(int row, const Eigen::Matrix3d& block, const Eigen::Matrix3d& held) noexcept;

  const BlockPattern& pattern_;
  std::vector<int> position_;   // per row
  std::vector<int> begin_;      // per group: its first step
  std::vector<int> column_;     // per step and row of the group: a position
  std::vector<int> block_;      // the same: of the pattern; -1: none
  std::vector<Three> values_;   // per step: rows of the four blocks
  std::vector<Three> inverse_;  // per group, of the diagonal: columns
  Vector free_;
  std::vector<Guide> guides_;
};

}  // namespace palpate::fem
