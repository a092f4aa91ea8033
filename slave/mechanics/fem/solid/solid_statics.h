// Static equilibria of a solid: the whole load at once if Newton's method converges, else in parts.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "slave/mechanics/fem/solid/equilibrium.h"
#include "slave/mechanics/fem/solid/solid_state.h"
#include "slave/mechanics/fem/solid/supports.h"

namespace palpate {

class SolidStatics {
 public:
  // Stores references to its arguments. `linear`: the law is linear, so that one solve is
  // sufficient.
  SolidStatics(Equilibrium& equilibrium, const Supports& supports, fem::SearchProgress& progress,
               bool linear, int unknowns);

  // Moves the state from its equilibrium under the last loads to that under the present ones, or
  // solves from rest. A body without supports requires balanced loads and moves without mean
  // displacement and rotation. False: failure() is the reason, if one is known.
  bool Solve(SolidState* state);
  // The next solution begins at rest.
  void Reset() { start_loads_.setZero(); }

  [[nodiscard]] int newton_steps() const { return newton_steps_; }
  [[nodiscard]] std::string_view failure() const { return failure_; }

 private:
  bool SolveInParts(SolidState* state);
  bool Fail(std::string_view why) {
    failure_ = why;
    return false;
  }

  Equilibrium& equilibrium_;
  const Supports& supports_;
  fem::SearchProgress& progress_;
  bool linear_;
  Eigen::VectorXd start_, good_, start_loads_;
  int newton_steps_ = 0;
  std::string_view failure_;
};

}  // namespace palpate
