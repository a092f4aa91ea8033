// LU factorisation with partial pivoting of large dense matrices that says how far it is and can be
// stopped.
#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/text/progress.h"

namespace palpate {

// Where an algorithm tells of itself: nullptr tells nobody.
class Stage {
 public:
  Stage(Progress* progress, std::string_view name) : progress_(progress), name_(name) {}
  // Throws Interrupted.
  void Report(double done) const {
    if (progress_ != nullptr && !progress_->Report(name_, done)) throw Interrupted();
  }

 private:
  Progress* progress_;
  std::string_view name_;
};

class PivotedLu {
 public:
  // Factorises in place, recursively over halves of the columns (Toledo 1997), so that nearly all
  // of the work is in matrix products. `A` is square, and kept by reference.
  PivotedLu(Eigen::MatrixXd* A, const Stage& stage);

  // B := A^-1 B, in blocks of columns.
  void Solve(Eigen::MatrixXd* B, const Stage& stage) const;
  // Estimate of 1 / (|A| |A^-1|) in the 1-norm (Hager 1984, Higham 1988); 0: singular.
  [[nodiscard]] double ReciprocalCondition() const;

 private:
  void Factorise(Eigen::Index first, Eigen::Index count, const Stage& stage);
  void FactoriseNarrow(Eigen::Index first, Eigen::Index count);
  void SwapRows(Eigen::Index first, Eigen::Index last, Eigen::Ref<Eigen::MatrixXd> columns) const;

  Eigen::MatrixXd& A_;
  double norm_ = 0;                  // of A, 1-norm
  std::vector<Eigen::Index> pivot_;  // row k was swapped with row pivot_[k]
};

}  // namespace palpate
