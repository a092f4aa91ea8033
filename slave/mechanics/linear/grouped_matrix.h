// A symmetric matrix of 3 x 3 blocks in single precision, for sweeps of block Gauss and Seidel.
//
// Rows are sorted by colour and then by length. No two rows of a colour are neighbours, so that
// four rows can be swept at a time without waiting for each other. Only the blocks right of the
// diagonal are kept, because they need half the cache; the others are their transposes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/lanes.h"

namespace palpate::fem {

// A row whose node moves perpendicular to the unit vector `normal` only.
struct Guide {
  int row = 0;
  Eigen::Vector3d normal{0, 0, 1};
};

class GroupedMatrix {
 public:
  // x, y, z and a zero of each of four rows.
  using Group = Float16;
  // Rows in the matrix's own order. The last group contains no rows and stays zero.
  using Vector = std::vector<Group>;

  // Keeps a reference to the pattern. All blocks are zero.
  explicit GroupedMatrix(const BlockPattern& pattern);

  // scale * A. `free` per row and component: 1 free, 0 fixed; a row of `guides` is fixed along its
  // normal. False: a block of the diagonal is not positive definite. Allocation-free.
  bool Set(const BlockMatrix& A, double scale, const NodeVector& free,
           std::span<const Guide> guides) noexcept;

  // In the next four functions L + D + L^T is the part of A with free rows and columns. Other
  // entries of the vectors do not count.
  //
  // Solves (L + D) z = r, replaces r by D z, and computes what remains: left = -L^T z.
  void SweepForward(Vector* r, Vector* z, Vector* left) const noexcept;
  // Sets the fixed components of x to zero.
  void Restrict(Vector* x) const noexcept;
  // y -= L x
  void SubtractLower(const Vector& x, Vector* y) const noexcept;
  // Solves (D + L^T) z = r, and adds L times the change of z to y.
  void SweepBackward(const Vector& r, Vector* z, Vector* y) const noexcept;

  // Returns the index of a row in a Vector that is read as an array of numbers.
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
  std::vector<int> column_;     // per step and row of the group: position of the column
  std::vector<int> block_;      // per step and row: block of the pattern; -1: none
  std::vector<Three> values_;   // per step: rows of the four blocks
  std::vector<Three> inverse_;  // per group, of the diagonal: columns
  Vector free_;
  std::vector<Guide> guides_;
};

}  // namespace palpate::fem
