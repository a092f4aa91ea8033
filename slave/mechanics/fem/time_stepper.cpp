#include "slave/mechanics/fem/time_stepper.h"

#include <algorithm>
#include <cmath>

#include "shared/geometry/index.h"

namespace palpate::fem {

constexpr int kMostNewton = 400;
constexpr int kMostParts = 64;
constexpr int kMostHalvings = 12;
constexpr double kInner = 1e-3;  // of a residual, where another Newton step follows
constexpr double kGain = 1e-6;   // of the energies that are exchanged
constexpr double kGainNewmark = 1e-3, kSurplus = 1e-2;  // the same
constexpr double kRounding = 1e-14;                     // of the forces that cancel
constexpr double kSufficient = 1e-4;

namespace {

// b = h theta (f_ext - f_int) + h (1 - theta) F_0.
void Push(const NodeVector& f_ext, const NodeVector& f_int, const NodeVector& momentum_force,
          double theta, double h, NodeVector& b) noexcept {
  b = f_ext;
  Add(-1, f_int, b);
  Scale(theta * h, b);
  if (theta < 1) Add(h * (1 - theta), momentum_force, b);
}

// reaction = A dv - b; r = P^T (b - A dv), which is its opposite where nothing acts.
void FindReaction(const BlockMatrix& A, const Constraints& constraints, const NodeVector& dv,
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
  if (params.newton != 1 || params.exact_tangent) start_.emplace(body.pattern());
  for (auto* x : {&now_.u, &now_.v, &f_int_, &reaction_, &now_.momentum_force, &u0_, &v0_, &dv_,
                  &b_, &r_, &x_, &lift_, &work_, &now_.outer}) {
    x->resize(Index(body.size()));
  }
  kept_ = now_;
}

void TimeStepper::Reset(const NodeVector& f_ext) noexcept {
  SetZero(now_.u);
  SetZero(now_.v);
  body_.ForgetRotations();
  Evaluate();
  now_.momentum_force = f_ext;
  now_.outer = f_ext;
  now_.energy = now_.surplus = 0;
  gain_.at_all = false;
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
  const int most = params_.newton == 0 ? kMostParts : 1;
  for (int parts = 1; parts <= most; parts *= 2) {
    const bool arrived = StepInParts(f_ext, constraints, parts);
    if (arrived && (!gain_.in_step || parts == most)) return true;
    if (parts == most) break;
    now_ = kept_;
    Evaluate();
  }
  now_ = kept_;
  body_.ForgetRotations();
  Evaluate();
  return false;
}

bool TimeStepper::StepInParts(const NodeVector& f_ext, const Constraints& constraints,
                              int parts) noexcept {
  bool step_gained = false, gained = false;
  for (int part = 0; part < parts; ++part) {
    if (!Advance(f_ext, constraints, params_.step / parts, 1.0 / (parts - part))) return false;
    step_gained = step_gained || gain_.in_step;
    gained = gained || gain_.at_all;
  }
  gain_.in_step = step_gained;
  gain_.at_all = gained;
  return true;
}

bool TimeStepper::Advance(const NodeVector& f_ext, const Constraints& constraints, double h,
                          double share) noexcept {
  u0_ = now_.u;
  v0_ = now_.v;
  AssembleStart(h);
  RightHandSide(f_ext, constraints, h);
  if (!SolveStart(constraints, h, share)) return false;
  SetMotion(h);
  if (!Evaluate()) return false;
  if (params_.newton != 1 && !params_.linear && !Refine(f_ext, constraints, h)) return false;
  Finish(f_ext, h);
  return std::isfinite(now_.energy);
}

// M + theta h D + theta^2 h^2 K, brought near one by a common factor.
void TimeStepper::AssembleStart(double h) noexcept {
  const double th = params_.theta * h;
  const double mass = 1 + th * params_.damping_mass;
  const double stiffness = th * (th + params_.damping_stiffness);
  if (params_.linear && assembled_for_ == h) return;
  body_.AssembleTangent(mass, stiffness, tangent_);
  if (start_) *start_ = tangent_;
  if (params_.exact_tangent && !params_.linear) body_.AddSpin(th * th, now_.u, tangent_);
  if (assembled_for_ != h) solver_.Renew();
  assembled_for_ = h;
}

// b = h theta (f_ext - f_int - h K_t v - D v) + h (1 - theta) F_0, at the start of the step.
void TimeStepper::RightHandSide(const NodeVector& f_ext, const Constraints& constraints,
                                double h) noexcept {
  const double th = params_.theta * h;
  Push(f_ext, f_int_, now_.momentum_force, params_.theta, h, b_);
  // (mass) M v and (stiffness) K v from A v = (mass) M v + (stiffness) K v.
  const double ratio = (h + params_.damping_stiffness) / (th + params_.damping_stiffness);
  const bool is_warped = !params_.exact_tangent || params_.linear;
  history_.Multiply(tangent_, constraints, now_.v, is_warped ? work_ : lift_);
  if (!is_warped) start_->Multiply(now_.v, work_);
  Add(-ratio, work_, b_);
  body_.MultiplyMass(now_.v, x_);
  Add(ratio * (1 + th * params_.damping_mass) - th * params_.damping_mass, x_, b_);
  if (is_warped) return;
  Add(-1, work_, lift_);
  Add(-1 / params_.theta, lift_, b_);
}

// dv_ of the linearised step, with what contacts prescribe.
bool TimeStepper::SolveStart(const Constraints& constraints, double h, double share) noexcept {
  const double th = params_.theta * h;
  constraints.Lift(u0_, 1, lift_);
  work_ = u0_;
  Add(h, v0_, work_);
  Scale(share - 1, lift_);
  x_ = lift_;
  constraints.Lift(work_, 1, lift_);
  Add(1, x_, lift_);
  for (auto& node : lift_) {
    for (double& value : node.v) value /= th;
  }
  r_ = b_;
  const double lifted = LargestComponent(lift_);
  if (lifted > 0) {
    tangent_.Multiply(lift_, work_);
    Add(-1, work_, r_);
  }
  constraints.ProjectForce(r_);
  const double size = Norm(r_);
  // A given number of linear solves is worth what each of them is.
  const bool last = params_.newton != 0 || params_.linear;
  const double target =
      std::max(size * (last ? params_.residual : std::max(kInner, params_.residual)), 1e-300);
  SetZero(x_);
  history_.Improve(r_, x_);
  SolveOutcome outcome = solver_.Solve(tangent_, constraints, r_, x_, target);
  if (outcome.indefinite && start_) {
    tangent_ = *start_;
    solver_.Renew();
    outcome = solver_.Solve(tangent_, constraints, r_, x_, target);
  }
  last_solve_.iterations = outcome.iterations;
  last_solve_.residual = size > 0 ? Norm(r_) / size : 0;
  history_.Keep(x_);
  dv_ = x_;
  if (lifted > 0) Add(1, lift_, dv_);
  FindReaction(tangent_, constraints, dv_, b_, r_, reaction_);
  return outcome.converged || Norm(r_) <= kRounding * Norm(b_);
}

// v = v_0 + dv, u = u_0 + h (v_0 + theta dv).
void TimeStepper::SetMotion(double h) noexcept {
  now_.v = v0_;
  Add(1, dv_, now_.v);
  now_.u = u0_;
  Add(h, v0_, now_.u);
  Add(h * params_.theta, dv_, now_.u);
}

// Newton's method on the step itself, from where its linearisation led.
bool TimeStepper::Refine(const NodeVector& f_ext, const Constraints& constraints,
                         double h) noexcept {
  const double th = params_.theta * h;
  const int most = params_.newton == 0 ? kMostNewton : params_.newton - 1;
  Residual(f_ext, h);
  const double reference = std::max(Norm(b_), Norm(reaction_));
  for (int step = 0; step < most; ++step) {
    constraints.ProjectForce(r_);
    const double size = Norm(r_);
    last_solve_.residual = reference > 0 ? size / reference : 0;
    if (!std::isfinite(size)) return false;
    if (size <= std::max(params_.residual, kRounding) * reference) return true;
    body_.AssembleTangent(1 + th * params_.damping_mass, th * (th + params_.damping_stiffness),
                          tangent_);
    if (params_.exact_tangent) body_.AddSpin(th * th, now_.u, tangent_);
    SetZero(x_);
    const double inner = params_.newton != 0
                             ? params_.residual
                             : std::max(kInner, 0.1 * params_.residual * reference / size);
    const double target = inner * size;
    const SolveOutcome outcome = solver_.Solve(tangent_, constraints, r_, x_, target);
    last_solve_.iterations += outcome.iterations;
    const double merit = Merit(f_ext, h);
    if (!TryMove(f_ext, constraints, h, size, merit)) return params_.newton != 0;
  }
  constraints.ProjectForce(r_);
  last_solve_.residual = reference > 0 ? Norm(r_) / reference : 0;
  return params_.newton != 0 || last_solve_.residual <= params_.residual;
}

// A share of x_ that lowers the residual or the incremental potential; r_ is the new residual.
bool TimeStepper::TryMove(const NodeVector& f_ext, const Constraints& constraints, double h,
                          double size, double merit) noexcept {
  double length = 1;
  for (int halving = 0; halving < kMostHalvings; ++halving) {
    Add(length, x_, dv_);
    SetMotion(h);
    const bool finite = Evaluate();
    Residual(f_ext, h);
    work_ = r_;
    constraints.ProjectForce(work_);
    if (finite && (Norm(work_) < (1 - kSufficient * length) * size || Merit(f_ext, h) < merit)) {
      return true;
    }
    Add(-length, x_, dv_);
    length *= 0.5;
  }
  SetMotion(h);
  Evaluate();
  Residual(f_ext, h);
  return false;
}

// r_ = h theta (f_ext - f_int - D v) + h (1 - theta) F_0 - M dv; reaction_ is its opposite.
void TimeStepper::Residual(const NodeVector& f_ext, double h) noexcept {
  const double th = params_.theta * h, b = params_.damping_stiffness;
  Push(f_ext, f_int_, now_.momentum_force, params_.theta, h, r_);
  body_.MultiplyMass(dv_, work_);
  Add(-1, work_, r_);
  body_.MultiplyMass(now_.v, work_);
  const double share = b > 0 ? b / (th + b) : 0;
  Add(share * (1 + th * params_.damping_mass) - th * params_.damping_mass, work_, r_);
  if (b > 0) {
    start_->Multiply(now_.v, work_);
    Add(-share, work_, r_);
  }
  reaction_ = r_;
  Scale(-1, reaction_);
}

// |dv|_M^2 / 2 + theta h v D v / 2 + W - f_ext u - h (1 - theta) F_0 dv: its derivative is -r_.
double TimeStepper::Merit(const NodeVector& f_ext, double h) noexcept {
  const double th = params_.theta * h, b = params_.damping_stiffness;
  body_.MultiplyMass(dv_, work_);
  double merit = 0.5 * Dot(dv_, work_) + summary_.energy - Dot(f_ext, now_.u);
  if (params_.theta < 1) merit -= h * (1 - params_.theta) * Dot(now_.momentum_force, dv_);
  body_.MultiplyMass(now_.v, work_);
  const double vMv = Dot(now_.v, work_);
  double vDv = th * params_.damping_mass * vMv;
  if (b > 0) {
    start_->Multiply(now_.v, work_);
    vDv += b / (th + b) * (Dot(now_.v, work_) - (1 + th * params_.damping_mass) * vMv);
  }
  return merit + 0.5 * vDv;
}

// Reactions as forces, the energies, and the forces that Newmark's method remembers.
void TimeStepper::Finish(const NodeVector& f_ext, double h) noexcept {
  const double th = params_.theta * h;
  for (std::size_t i = 0; i < reaction_.size(); ++i) {
    const bool moves = static_cast<int>(i) < body_.moving();
    for (std::size_t c = 0; c < 3; ++c) {
      reaction_[i].v[c] = moves ? reaction_[i].v[c] / th : f_int_[i].v[c] - f_ext[i].v[c];
    }
  }
  Balance(f_ext);
  if (params_.theta == 1) return;
  body_.MultiplyMass(dv_, work_);
  for (std::size_t i = 0; i < work_.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      now_.momentum_force[i].v[c] =
          (work_[i].v[c] / h - (1 - params_.theta) * now_.momentum_force[i].v[c]) / params_.theta;
    }
  }
}

// The energy, and what of it did not come in through loads and contacts.
void TimeStepper::Balance(const NodeVector& f_ext) noexcept {
  const double theta = params_.theta, before = now_.energy;
  body_.MultiplyMass(now_.v, work_);
  now_.energy = summary_.energy + 0.5 * Dot(now_.v, work_);
  x_ = now_.u;
  Add(-1, u0_, x_);
  const double earlier = (1 - theta) * Dot(now_.outer, x_);
  const double by_loads = theta * Dot(f_ext, x_), by_contacts = theta * Dot(reaction_, x_);
  now_.outer = f_ext;
  Add(1, reaction_, now_.outer);
  const double gain = now_.energy - before - earlier - by_loads - by_contacts;
  const double scale =
      std::max({now_.energy, before, std::abs(earlier), std::abs(by_loads), std::abs(by_contacts)});
  now_.surplus = theta < 1 ? std::max(0.0, now_.surplus + gain) : 0;
  gain_.in_step = gain > (theta < 1 ? kGainNewmark : kGain) * scale;
  gain_.at_all = gain_.in_step || now_.surplus > kSurplus * scale;
}

}  // namespace palpate::fem
