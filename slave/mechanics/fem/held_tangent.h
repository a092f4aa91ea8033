// The tangent of a body in the form for a factorisation: the scalar entries of the upper triangle,
// with rows of fixed components replaced.
#pragma once

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/sparse_ldlt.h"

namespace palpate::fem {

class HeldTangent {
 public:
  using Matrix = SparseLdlt<double>::Matrix;

  // Stores a reference to the pattern. All values are zero.
  explicit HeldTangent(const BlockPattern& pattern);

  // scale * matrix; the scale brings its diagonal near one. Allocation-free.
  void Fill(const BlockMatrix& matrix, double scale, const HeldComponents& held) noexcept;
  [[nodiscard]] const Matrix& upper() const { return upper_; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  // Returns the entry for component r of the k-th block's column and component c of its row, at or
  // left of the diagonal.
  double& At(int row, int k, int r, int c) noexcept;

  const BlockPattern& pattern_;
  Matrix upper_;
};

}  // namespace palpate::fem
