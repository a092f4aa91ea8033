// Motion of a body in steps of time, implicit: with v = v_0 + dv and u = u_0 + h (v_0 + theta dv)
//
//   M dv / h = theta (f_ext - f_int(u) - D v + reactions) + (1 - theta) F_0,   D = a M + b K(u_0)
//
// theta = 1: implicit Euler; theta = 1/2 with F_0 the last step's forces: Newmark's average
// acceleration. One linear solve per step linearises at u_0: the public co-rotational codes do so.
// Sources: Baraff and Witkin (1998); Hughes, The Finite Element Method, ch. 9.
#pragma once

#include <optional>
#include <tuple>

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

  [[nodiscard]] const NodeVector& displacement() const { return u_; }
  // What supports and contacts add, on nodes that move; f_int - f_ext on the others.
  [[nodiscard]] const NodeVector& reaction() const { return reaction_; }
  [[nodiscard]] const ElementSummary& summary() const { return summary_; }
  [[nodiscard]] double energy() const { return energy_; }  // elastic and kinetic
  // The last step ended with more energy than was put in, by more than rounding; in Newmark's
  // method, whose energy swings about the true one, by a thousandth or, over the steps, a hundredth
  // of the energies that are exchanged.
  [[nodiscard]] bool gained_energy() const { return gained_energy_; }
  [[nodiscard]] double residual() const { return relative_residual_; }  // of its last linear solve
  [[nodiscard]] int iterations() const { return iterations_; }          // of it
  [[nodiscard]] std::size_t memory_bytes() const {
    return tangent_.memory_bytes() + solver_.memory_bytes();
  }

 private:
  bool StepInParts(const NodeVector& f_ext, const Constraints& constraints, int parts) noexcept;
  bool Advance(const NodeVector& f_ext, const Constraints& constraints, double h,
               double share) noexcept;
  void AssembleStart(double h) noexcept;
  void Push(const NodeVector& f_ext, double h, NodeVector& b) const noexcept;
  void RightHandSide(const NodeVector& f_ext, double h) noexcept;
  bool SolveStart(const Constraints& constraints, double h, double share) noexcept;
  bool Refine(const NodeVector& f_ext, const Constraints& constraints, double h) noexcept;
  bool TryMove(const NodeVector& f_ext, const Constraints& constraints, double h, double size,
               double merit) noexcept;
  double Merit(const NodeVector& f_ext, double h) noexcept;
  void Residual(const NodeVector& f_ext, double h) noexcept;
  void SetMotion(double h) noexcept;
  void Finish(const NodeVector& f_ext, double h) noexcept;
  void Balance(const NodeVector& f_ext) noexcept;
  // What a step begins with and is taken back to.
  auto State() noexcept { return std::tie(u_, v_, momentum_force_, outer_, energy_, surplus_); }
  bool Evaluate() noexcept;

  FemBody& body_;
  Params params_;
  BlockMatrix tangent_;
  std::optional<BlockMatrix> start_;  // warped, at the start of the step; for damping and newton
  LinearSolver solver_;
  SolutionHistory history_;
  double assembled_for_ = 0;  // the step the linear law's tangent is for
  NodeVector u_, v_, f_int_, reaction_;
  NodeVector momentum_force_;  // F_0
  NodeVector outer_;           // f_ext and reactions at the end of the last step
  NodeVector u0_, v0_, dv_, b_, r_, x_, lift_, work_;
  std::tuple<NodeVector, NodeVector, NodeVector, NodeVector, double, double> kept_;
  ElementSummary summary_;
  double energy_ = 0, relative_residual_ = 0;
  int iterations_ = 0;
  double surplus_ = 0;  // energy from nowhere that was not lost again; Newmark's
  bool step_gained_ = false, gained_energy_ = false;
};

}  // namespace palpate::fem
