// Motion of a body in steps of time, implicit Euler: with v = v_0 + dv and u = u_0 + h v
//
//   M dv / h = f_ext - f_int(u) + reactions
//
// One linear solve per step linearises at u_0: the public co-rotational codes do so. Source: Baraff
// and Witkin (1998).
#pragma once

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/linear_solver.h"
#include "slave/mechanics/linear/block_matrix.h"

namespace palpate::fem {

class TimeStepper {
 public:
  struct Params {
    double step = 0;         // h, in the body's unit of time, > 0
    double residual = 1e-6;  // relative to the norm of the right-hand side
    bool linear = false;
  };
  // Stores a reference to the body.
  TimeStepper(FemBody& body, const Params& params);

  // At rest.
  void Reset() noexcept;
  // Call when the fixed components have changed.
  void Renew() noexcept {
    solver_.Renew();
    history_.Clear();
  }
  // Makes one step; the forces and constraints apply at its end. Returns false without convergence
  // or with values that are not finite; the motion is then unchanged.
  bool Step(const NodeVector& f_ext, const Constraints& constraints) noexcept;
  // The motion is as before the last step.
  void TakeBack() noexcept;

  [[nodiscard]] const NodeVector& displacement() const { return now_.u; }
  // Forces of supports and contacts on moving nodes; f_int - f_ext on the others.
  [[nodiscard]] const NodeVector& reaction() const { return reaction_; }
  [[nodiscard]] const ElementSummary& summary() const { return summary_; }
  [[nodiscard]] double energy() const { return now_.energy; }  // elastic and kinetic
  // Returns whether the last step ended with more energy than was added, beyond rounding.
  [[nodiscard]] bool gained_energy() const { return gained_energy_; }
  struct LinearSolve {
    double residual = 0;  // relative
    int iterations = 0;
  };
  [[nodiscard]] const LinearSolve& last_solve() const { return last_solve_; }
  [[nodiscard]] std::size_t memory_bytes() const {
    return tangent_.memory_bytes() + solver_.memory_bytes();
  }

 private:
  struct Motion {
    NodeVector u, v;
    double energy = 0;  // elastic and kinetic
  };

  bool Advance(const NodeVector& f_ext, const Constraints& constraints) noexcept;
  void Assemble() noexcept;
  void RightHandSide(const NodeVector& f_ext, const Constraints& constraints) noexcept;
  bool Solve(const Constraints& constraints) noexcept;
  void SetMotion() noexcept;
  void FindReaction(const NodeVector& f_ext) noexcept;
  void Balance(const NodeVector& f_ext) noexcept;
  bool Evaluate() noexcept;

  FemBody& body_;
  Params params_;
  BlockMatrix tangent_;
  LinearSolver solver_;
  SolutionHistory history_;
  bool is_assembled_ = false;
  Motion now_, kept_;  // kept_: state at the start of a step, restored if the step fails
  NodeVector f_int_, reaction_;
  NodeVector dv_, b_, r_, x_, lift_, work_;
  ElementSummary summary_;
  LinearSolve last_solve_;
  bool gained_energy_ = false;
};

}  // namespace palpate::fem
