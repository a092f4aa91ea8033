// A first guess from the last solutions: the best combination of the last one and its first and
// second differences in the norm of the matrix. Source: Fischer (1998).
#pragma once

#include <array>

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/node_vector.h"

namespace palpate::fem {

class SolutionHistory {
 public:
  explicit SolutionHistory(int nodes);

  void Clear() noexcept { known_ = 0; }
  void Keep(const NodeVector& solution) noexcept;
  // x += guess, r -= P^T A guess; `r` = P^T (b - A x).
  void Improve(const BlockMatrix& A, const Constraints& constraints, NodeVector& r,
               NodeVector& x) noexcept;

 private:
  static constexpr int kDepth = 3;

  int known_ = 0;
  std::array<NodeVector, kDepth> differences_;  // of rising order
  std::array<NodeVector, kDepth> directions_, products_;
  NodeVector change_;
};

}  // namespace palpate::fem
