#include "slave/mechanics/fem/time_stepper.h"

#include <algorithm>
#include <cmath>

#include "slave/mesh/index.h"

namespace palpate::fem {

namespace {

constexpr double kGain = 1e-6;              // tolerance relative to the exchanged energies
constexpr double kBalanceRounding = 1e-14;  // of the forces that cancel

// Computes reaction = A dv - b and r = P^T (b - A dv), which is the negative reaction at free
// nodes.
void LinearReaction(const BlockMatrix& A, const Constraints& constraints, const NodeVector& dv,
                    const NodeVector& b, const NodeVector& r, NodeVector& reaction) noexcept {
  reaction = r;
  Scale(-1, reaction);
  const auto complete = [&](int row) {
    At(reaction, row) = A.Row(row, dv);
    for (std::size_t c = 0; c < 3; ++c) At(reaction, row).v[c] -= At(b, row).v[c];
  };
  if (constraints.ForBearing(complete)) return;
  A.Multiply(dv, reaction);
  Add(-1, b, reaction);
}

}  // namespace

TimeStepper::TimeStepper(FemBody& body, const Params& params)
    : body_(body),
      params_(params),
      tangent_(body.pattern()),
      solver_(body, {.single = !params.linear}),
      history_(body.size()) {
  for (auto* x : {&now_.u, &now_.v, &f_int_, &reaction_, &dv_, &b_, &r_, &x_, &lift_, &work_}) {
    x->resize(Index(body.size()));
  }
  kept_ = now_;
}

void TimeStepper::Reset() noexcept {
  SetZero(now_.u);
  SetZero(now_.v);
  body_.ForgetRotations();
  Evaluate();
  now_.energy = 0;
  gained_energy_ = false;
  solver_.Reset();
  history_.Clear();
}

bool TimeStepper::Evaluate() noexcept {
  summary_ = body_.Evaluate(now_.u);
  body_.InternalForce(f_int_);
  return std::isfinite(summary_.energy);
}

bool TimeStepper::Step(const NodeVector& f_ext, const Constraints& constraints) noexcept {
  kept_ = now_;
  if (Advance(f_ext, constraints)) return true;
  TakeBack();
  return false;
}

void TimeStepper::TakeBack() noexcept {
  now_ = kept_;
  body_.ForgetRotations();
  Evaluate();
}

bool TimeStepper::Advance(const NodeVector& f_ext, const Constraints& constraints) noexcept {
  Assemble();
  RightHandSide(f_ext, constraints);
  if (!Solve(constraints)) return false;
  SetMotion();
  if (!Evaluate()) return false;
  FindReaction(f_ext);
  Balance(f_ext);
  return std::isfinite(now_.energy);
}

// Assembles A = M + h^2 K.
void TimeStepper::Assemble() noexcept {
  if (params_.linear && is_assembled_) return;
  body_.AssembleTangent(1, params_.step * params_.step, tangent_);
  if (!is_assembled_) solver_.Renew();
  is_assembled_ = true;
}

// b = h (f_ext - f_int - h K v) = h (f_ext - f_int) - A v + M v, at the start of the step.
void TimeStepper::RightHandSide(const NodeVector& f_ext, const Constraints& constraints) noexcept {
  b_ = f_ext;
  Add(-1, f_int_, b_);
  Scale(params_.step, b_);
  history_.Multiply(tangent_, constraints, now_.v, work_);
  Add(-1, work_, b_);
  body_.MultiplyMass(now_.v, x_);
  Add(1, x_, b_);
}

// Solves for dv_ of the linearised step with the prescribed motion of contacts.
bool TimeStepper::Solve(const Constraints& constraints) noexcept {
  const double h = params_.step;
  work_ = now_.u;
  Add(h, now_.v, work_);
  constraints.Lift(work_, 1, lift_);
  for (auto& node : lift_) {
    for (double& value : node.v) value /= h;
  }
  r_ = b_;
  const double lifted = LargestComponent(lift_);
  if (lifted > 0) {
    tangent_.Multiply(lift_, work_);
    Add(-1, work_, r_);
  }
  constraints.ProjectForce(r_);
  const double size = Norm(r_);
  const double target = std::max(size * params_.residual, 1e-300);
  SetZero(x_);
  history_.Improve(r_, x_);
  const SolveOutcome outcome = solver_.Solve(tangent_, constraints, r_, x_, target);
  last_solve_.iterations = outcome.iterations;
  last_solve_.residual = size > 0 ? Norm(r_) / size : 0;
  history_.Keep(x_);
  dv_ = x_;
  if (lifted > 0) Add(1, lift_, dv_);
  LinearReaction(tangent_, constraints, dv_, b_, r_, reaction_);
  return outcome.converged || Norm(r_) <= kBalanceRounding * Norm(b_);
}

// v = v_0 + dv, u = u_0 + h v.
void TimeStepper::SetMotion() noexcept {
  Add(1, dv_, now_.v);
  Add(params_.step, now_.v, now_.u);
}

// For moving nodes impulses are converted to forces; for fixed nodes the reaction is the imbalance.
void TimeStepper::FindReaction(const NodeVector& f_ext) noexcept {
  for (std::size_t i = 0; i < reaction_.size(); ++i) {
    const bool moves = static_cast<int>(i) < body_.moving();
    for (std::size_t c = 0; c < 3; ++c) {
      reaction_[i].v[c] = moves ? reaction_[i].v[c] / params_.step : f_int_[i].v[c] - f_ext[i].v[c];
    }
  }
}

// Updates the energy, and the part that loads and contacts did not add.
void TimeStepper::Balance(const NodeVector& f_ext) noexcept {
  const double before = now_.energy;
  body_.MultiplyMass(now_.v, work_);
  now_.energy = summary_.energy + 0.5 * Dot(now_.v, work_);
  x_ = now_.u;
  Add(-1, kept_.u, x_);
  const double by_loads = Dot(f_ext, x_), by_contacts = Dot(reaction_, x_);
  const double scale = std::max({now_.energy, before, std::abs(by_loads), std::abs(by_contacts)});
  gained_energy_ = now_.energy - before - by_loads - by_contacts > kGain * scale;
}

}  // namespace palpate::fem
