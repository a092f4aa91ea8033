// Motion of a body in steps of time, implicit: with v = v_0 + dv and u = u_0 + h (v_0 + theta dv)
//
//   M dv / h = theta (f_ext - f_int(u) - D v + reactions) + (1 - theta) F_0,   D = a M + b K(u_0)
//
// theta = 1: implicit Euler; theta = 1/2 with F_0 the last step's forces: Newmark's average
// acceleration. One linear solve per step linearises at u_0: the public co-rotational codes do so.
// Sources: Baraff and Witkin (1998); Hughes, The Finite Element Method, ch. 9.
#pragma once

#include <optional>

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/linear_solver.h"
#include "slave/mechanics/linear/block_matrix.h"

namespace palpate::fem {

class TimeStepper {
 public:
  struct Params {
    double step = 0;          // h, in the body's unit of time, > 0
    double theta = 1;         // 1 or 1/2
    int newton = 1;           // linear solves per step; 0: until `residual`
    double residual = 1e-6;   // of the right hand side's norm
    double damping_mass = 0;  // a, b: in units of time
    double damping_stiffness = 0;
    bool exact_tangent = false;
    bool linear = false;
  };
  // Keeps a reference to the body.
  TimeStepper(FemBody& body, const Params& params);

  // At rest; `f_ext` acts from then on.
  void Reset(const NodeVector& f_ext) noexcept;
  // Call when the fixed components have changed.
  void Renew() noexcept {
    solver_.Renew();
    history_.Clear();
  }
  // One step, at whose end the forces and constraints hold. Solved until `residual`, a step that
  // does not arrive or gains energy from nowhere is divided by up to 64. False: no convergence or
  // not finite; the motion is as before.
  bool Step(const NodeVector& f_ext, const Constraints& constraints) noexcept;

  [[nodiscard]] const NodeVector& displacement() const { return now_.u; }
  // What supports and contacts add, on nodes that move; f_int - f_ext on the others.
  [[nodiscard]] const NodeVector& reaction() const { return reaction_; }
  [[nodiscard]] const ElementSummary& summary() const { return summary_; }
  [[nodiscard]] double energy() const { return now_.energy; }  // elastic and kinetic
  // The last step ended with more energy than was put in, by more than rounding; in Newmark's
  // method, whose energy swings about the true one, by a thousandth or, over the steps, a hundredth
  // of the energies that are exchanged.
  [[nodiscard]] bool gained_energy() const { return gain_.at_all; }
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
    NodeVector momentum_force;  // F_0
    NodeVector outer;           // f_ext and reactions at the end of the last step
    double energy = 0;          // elastic and kinetic
    double surplus = 0;         // energy from nowhere that was not lost again; Newmark's
  };
  struct Gain {  // of energy from nowhere
    bool in_step = false, at_all = false;
  };

  bool StepInParts(const NodeVector& f_ext, const Constraints& constraints, int parts) noexcept;
  bool Advance(const NodeVector& f_ext, const Constraints& constraints, double h,
               double share) noexcept;
  void AssembleStart(double h) noexcept;
  void RightHandSide(const NodeVector& f_ext, const Constraints& constraints, double h) noexcept;
  bool SolveStart(const Constraints& constraints, double h, double share) noexcept;
  bool Refine(const NodeVector& f_ext, const Constraints& constraints, double h) noexcept;
  bool TryMove(const NodeVector& f_ext, const Constraints& constraints, double h, double size,
               double merit) noexcept;
  double Merit(const NodeVector& f_ext, double h) noexcept;
  void Residual(const NodeVector& f_ext, double h) noexcept;
  void SetMotion(double h) noexcept;
  void Finish(const NodeVector& f_ext, double h) noexcept;
  void Balance(const NodeVector& f_ext) noexcept;
  bool Evaluate() noexcept;

  FemBody& body_;
  Params params_;
  BlockMatrix tangent_;
  std::optional<BlockMatrix> start_;  // warped, at the start of the step; for damping and newton
  LinearSolver solver_;
  SolutionHistory history_;
  double assembled_for_ = 0;  // the step the linear law's tangent is for
  Motion now_, kept_;         // kept: a step begins with it and is taken back to it
  NodeVector f_int_, reaction_;
  NodeVector u0_, v0_, dv_, b_, r_, x_, lift_, work_;
  ElementSummary summary_;
  LinearSolve last_solve_;
  Gain gain_;
};

}  // namespace palpate::fem
