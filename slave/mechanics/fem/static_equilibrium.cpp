#include "slave/mechanics/fem/static_equilibrium.h"

#include <algorithm>
#include <cmath>

#include "shared/geometry/index.h"

namespace palpate::fem {
namespace {

constexpr int kMostSteps = 1000;   // of Newton's method
constexpr int kMostHalvings = 24;  // of one such step
constexpr double kInner = 1e-2;    // of a linear system's right hand side
constexpr double kSufficient = 1e-4;
// Where a factor makes digits cheap, the residual is driven this far below what is asked for.
constexpr double kAimDirect = 1e-4, kAimIterative = 0.3;
constexpr double kRounding = 4e-16;  // of the diagonal's forces
constexpr double kStalled = 0.5;

// What rounding leaves of forces that should cancel.
double RoundingFloor(const BlockMatrix& A, const NodeVector& u) {
  double square = 0;
  for (int i = 0; i < A.pattern().rows(); ++i) {
    const double* block = A.block(A.pattern().diagonal[Index(i)]);
    for (std::size_t c = 0; c < 3; ++c) {
      const double force = block[4 * c] * At(u, i).v[c];
      square += force * force;
    }
  }
  return kRounding * std::sqrt(square);
}

}  // namespace

StaticEquilibrium::StaticEquilibrium(FemBody& body, const Params& params)
    : body_(body),
      params_(params),
      progress_(params.progress, params.linear),
      tangent_(body.pattern()),
      solver_(body, {.late_factor = true, .progress = &progress_}) {
  for (auto* x : {&u_, &last_u_, &f_ext_, &f_int_, &r_, &x_, &lift_, &trial_, &reaction_}) {
    x->resize(Index(body.size()));
  }
}

void StaticEquilibrium::Reset() noexcept {
  SetZero(u_);
  SetZero(reaction_);
  summary_ = {};
  body_.ForgetRotations();
  solver_.Reset();
}

bool StaticEquilibrium::Solve(const NodeVector& f_ext, const Constraints& constraints) noexcept {
  last_u_ = u_;
  f_ext_ = f_ext;
  progress_.Begin();
  if (Iterate(constraints, 1)) return true;
  if (!params_.linear) {
    for (const int steps : {1, 8, 64}) {
      if (progress_.stopped()) break;
      if (SolveInSteps(constraints, steps)) return true;
    }
  }
  u_ = last_u_;
  Update();
  return false;
}

bool StaticEquilibrium::SolveInSteps(const Constraints& constraints, int steps) noexcept {
  SetZero(u_);
  body_.ForgetRotations();
  for (int step = 1; step <= steps; ++step) {
    if (!Iterate(constraints, static_cast<double>(step) / steps)) return false;
  }
  return true;
}

void StaticEquilibrium::Update() noexcept {
  summary_ = body_.Evaluate(u_);
  body_.InternalForce(f_int_);
}

// r_ = P^T (share f_ext - f_int); its norm, and reaction_.
double StaticEquilibrium::FreeResidual(const Constraints& constraints, double share) noexcept {
  r_ = f_int_;
  Add(-share, f_ext_, r_);
  reaction_ = r_;
  Scale(-1, r_);
  constraints.ProjectForce(r_);
  Add(1, r_, reaction_);
  const double size = Norm(r_);
  reference_ = std::max({share * Norm(f_ext_), Norm(reaction_), released_});
  Add(-1, r_, reaction_);
  return size;
}

bool StaticEquilibrium::Iterate(const Constraints& constraints, double share) noexcept {
  Update();
  released_ = 0;
  bool lifted = constraints.Lift(u_, share, lift_) > 0;
  double size = FreeResidual(constraints, share), previous = size;
  released_ = lifted ? 0 : kInner * size;
  const double aim = solver_.direct() ? kAimDirect : kAimIterative;
  for (int step = 0; step < kMostSteps && std::isfinite(size); ++step) {
    const double asked = params_.residual * std::max(reference_, released_);
    relative_residual_ = size > 0 ? size / std::max(reference_, released_) : 0;
    const bool stalled = step > 0 && size > kStalled * previous;
    if (!lifted && (size <= aim * asked || (size <= asked && stalled))) return true;
    if (!assembled_ || !params_.linear) {
      body_.AssembleTangent(0, 1, tangent_);
      assembled_ = true;
    }
    const double floor = RoundingFloor(tangent_, u_);
    if (!lifted && step > 0 && size <= floor) return true;
    previous = size;
    progress_.Reach(size, aim * asked);
    if (!progress_.Continue()) return false;
    if (!Advance(constraints, share, lifted, floor)) return size <= asked && !lifted;
    lifted = false;
    size = FreeResidual(constraints, share);
  }
  return false;
}

// One step of Newton's method.
bool StaticEquilibrium::Advance(const Constraints& constraints, double share, bool lifted,
                                double floor) noexcept {
  const double size = Norm(r_), energy = summary_.energy - share * Dot(f_ext_, u_);
  trial_ = r_;
  SetZero(x_);
  if (lifted) {
    tangent_.Multiply(lift_, x_);
    constraints.ProjectForce(x_);
    Add(-1, x_, trial_);
    SetZero(x_);
  }
  const double aim = solver_.direct() ? kAimDirect : kAimIterative;
  const double inner = params_.linear ? 0.5 * aim * params_.residual : kInner;
  const double target = std::max(inner * Norm(trial_), floor);
  const SolveOutcome outcome = solver_.Solve(tangent_, constraints, trial_, x_, target);
  if (outcome.indefinite) {
    body_.AssembleTangent(0, 1, tangent_);
    solver_.Renew();
    solver_.Solve(tangent_, constraints, trial_, x_, target);
  }
  const double slope = Dot(r_, x_);
  trial_ = u_;
  if (lifted) Add(1, lift_, x_);
  double length = 1;
  for (int halving = 0; halving < kMostHalvings; ++halving, length *= 0.5) {
    u_ = trial_;
    Add(length, x_, u_);
    Update();
    if (lifted || params_.linear) return std::isfinite(summary_.energy);
    const double now = summary_.energy - share * Dot(f_ext_, u_);
    if (now <= energy - kSufficient * length * slope) return true;
    if (FreeResidual(constraints, share) < (1 - kSufficient * length) * size) return true;
  }
  u_ = trial_;
  Update();
  FreeResidual(constraints, share);
  return false;
}

}  // namespace palpate::fem
