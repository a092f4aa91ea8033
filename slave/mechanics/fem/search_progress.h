// How far a search for equilibrium is, for whoever waits for it and may want it to stop.
#pragma once

#include <chrono>

#include "shared/text/progress.h"

namespace palpate::fem {

// Silent for its first tenth of a second and told ten times a second after it, so that quick
// searches stay free of whatever the telling costs.
class SearchProgress {
 public:
  // `progress` may be null, else it must outlive this. `linear`: one linear system is the search.
  SearchProgress(Progress* progress, bool linear) : progress_(progress), linear_(linear) {}

  // A search begins, or begins anew from another start.
  void Begin() noexcept;
  // Its residual is `residual`, wanted is `target`; the share done is that of the digits.
  void Reach(double residual, double target) noexcept;
  // The same of a linear system on the way.
  void ReachInner(double residual, double target) noexcept {
    if (linear_) Reach(residual, target);
  }
  // False: stop, now and until the next Begin.
  [[nodiscard]] bool Continue() noexcept { return Tell("finding the equilibrium", done_); }
  // The same while a factor is made, of which `done` is there.
  [[nodiscard]] bool ContinueFactor(double done) noexcept {
    return Tell("factoring the stiffness", done);
  }
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  using Clock = std::chrono::steady_clock;

  bool Tell(const char* stage, double done) noexcept;

  Progress* progress_;
  bool linear_;
  bool stopped_ = false;
  double first_ = 0;  // residual of the search
  double done_ = 0;   // never falls
  Clock::time_point told_;
};

}  // namespace palpate::fem
