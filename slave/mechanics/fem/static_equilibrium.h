// Equilibrium of a body at rest: f_int(u) = f_ext among the possible motions, by Newton's method
// with the warped tangent and a line search on the potential energy.
#pragma once

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/linear_solver.h"
#include "slave/mechanics/fem/search_progress.h"
#include "slave/mechanics/linear/block_matrix.h"

namespace palpate::fem {

class StaticEquilibrium {
 public:
  struct Params {
    double residual = 1e-6;  // of the loads' norm, supports' and contacts' reactions counted
    bool linear = false;
    Progress* progress = nullptr;  // of searches that take long; may be null, else outlives this
  };
  // Keeps a reference to the body.
  StaticEquilibrium(FemBody& body, const Params& params);

  // As after construction: at rest.
  void Reset() noexcept;
  // Call when the fixed components have changed.
  void Renew() noexcept { solver_.Reset(); }
  // Finds u for the forces and constraints, from the last one or, should that fail, from rest in
  // steps. False: not found, or stopped; the last equilibrium is kept.
  bool Solve(const NodeVector& f_ext, const Constraints& constraints) noexcept;

  [[nodiscard]] bool interrupted() const { return progress_.stopped(); }
  [[nodiscard]] const NodeVector& displacement() const { return u_; }
  // f_int - f_ext: what supports and contacts add.
  [[nodiscard]] const NodeVector& reaction() const { return reaction_; }
  [[nodiscard]] const ElementSummary& summary() const { return summary_; }
  [[nodiscard]] double residual() const { return relative_residual_; }  // reached
  [[nodiscard]] std::size_t memory_bytes() const {
    return tangent_.memory_bytes() + solver_.memory_bytes();
  }

 private:
  bool SolveInSteps(const Constraints& constraints, int steps) noexcept;
  bool Iterate(const Constraints& constraints, double share) noexcept;
  void Update() noexcept;
  double FreeResidual(const Constraints& constraints, double share) noexcept;
  bool Advance(const Constraints& constraints, double share, bool lifted, double floor) noexcept;

  FemBody& body_;
  Params params_;
  SearchProgress progress_;
  BlockMatrix tangent_;
  LinearSolver solver_;
  bool assembled_ = false;  // the linear law's tangent
  NodeVector u_, last_u_, f_ext_, f_int_, r_, x_, lift_, trial_, reaction_;
  ElementSummary summary_;
  double reference_ = 0;  // the loads' and reactions' norm
  double released_ = 0;   // what counts in its place where loads are gone
  double relative_residual_ = 0;
};

}  // namespace palpate::fem
