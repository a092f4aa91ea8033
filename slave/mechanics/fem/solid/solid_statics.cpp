#include "slave/mechanics/fem/solid/solid_statics.h"

#include <algorithm>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::VectorXd;

constexpr double kBalanced = 1e-6;  // work of loads on free motions over all work
// Force on pinned unknowns relative to the loads, after the deformation.
constexpr double kStillBalanced = 1e-3;
constexpr double kMinPart = 1.0 / 64;  // smallest share of a load that is applied at once
constexpr int kMaxTotalSteps = 300;    // of Newton's method for one answer, all parts together

}  // namespace

SolidStatics::SolidStatics(Equilibrium& equilibrium, const Supports& supports,
                           fem::SearchProgress& progress, bool linear, int unknowns)
    : equilibrium_(equilibrium),
      supports_(supports),
      progress_(progress),
      linear_(linear),
      start_(VectorXd::Zero(unknowns)),
      good_(start_),
      start_loads_(start_) {}

bool SolidStatics::Solve(SolidState* state) {
  failure_ = {};
  if (supports_.is_free() && supports_.Imbalance(state->loads) > kBalanced) {
    return Fail("loads on a body that is free to move do not balance");
  }
  start_ = state->x;
  newton_steps_ = 0;
  progress_.Begin();
  if (!SolveInParts(state)) {
    if (progress_.stopped() || linear_ || start_.isZero(0)) return false;
    newton_steps_ = 0;
    Reset();  // starts from rest instead of the last answer
    state->Rest();
    start_ = state->x;
    if (!SolveInParts(state)) return false;
  }
  start_loads_ = state->loads;
  if (!supports_.is_free()) return true;
  if (supports_.PinForce(equilibrium_.unbalanced()) > kStillBalanced * state->loads.norm()) {
    return Fail("loads on a body that is free to move do not balance once it has deformed");
  }
  supports_.RemoveFreeMotion(&state->x);
  return true;
}

// Applies the whole load at once if Newton's method converges, else parts that are halved until it
// does.
bool SolidStatics::SolveInParts(SolidState* state) {
  VectorXd& x = state->x;
  Balance& balance = state->balance;
  good_ = start_;
  double done = 0, part = 1;
  while (done < 1) {
    const double t = std::min(1.0, done + part);
    balance.force = (1 - t) * start_loads_ + t * state->loads;
    for (int i = 0; i < x.size(); ++i) {
      if (balance.fixed[Index(i)]) balance.given[i] = (1 - t) * start_[i] + t * state->target[i];
    }
    for (std::size_t k = 0; k < balance.rows.size(); ++k) {
      double from = 0;
      for (const auto& [unknown, weight] : balance.rows[k].weights) {
        from += weight * start_[unknown];
      }
      balance.rows[k].value = (1 - t) * from + t * state->row_target[k];
    }
    x = good_;
    const bool solved = equilibrium_.Solve(&balance, &x);
    newton_steps_ += equilibrium_.newton_steps();
    if (solved) {
      good_ = x;
      done = t;
      part *= 2;
      continue;
    }
    part /= 2;
    if (progress_.stopped() || part < kMinPart || newton_steps_ > kMaxTotalSteps || linear_) {
      return false;
    }
  }
  return true;
}

}  // namespace palpate
