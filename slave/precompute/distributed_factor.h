// The factor of a sparse positive definite matrix of which every rank has a share, by MUMPS.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/SparseCore>

#include "slave/precompute/ranks.h"

namespace palpate {

struct Mumps;

// All calls are made by every rank.
class DistributedFactor {
 public:
  // The lower triangle is the sum of the shares of all ranks; `order`: its rows in the order of
  // elimination. Throws on every rank: see SpdFactor.
  DistributedFactor(const Ranks& ranks, Eigen::SparseMatrix<double> share,
                    const std::vector<int>& order);
  ~DistributedFactor();
  DistributedFactor(const DistributedFactor&) = delete;
  DistributedFactor& operator=(const DistributedFactor&) = delete;

  // In place, `count` right-hand sides column by column, on the first rank.
  void Solve(double* columns, int count);

 private:
  std::unique_ptr<Mumps> mumps_;
};

}  // namespace palpate
