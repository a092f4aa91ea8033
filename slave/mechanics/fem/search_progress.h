// Progress of a search for equilibrium, for callers that display it or stop it.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

#include "shared/state/clock.h"
#include "shared/state/driven_clock.h"
#include "slave/program/progress.h"

namespace palpate::fem {

// Silent during the first tenth of a second, then ten reports per second, so that quick searches
// have no overhead. With a driven clock there are none, since a report may stop a search.
class SearchProgress {
 public:
  // `progress` may be null, else it must outlive this. `linear`: one linear system is the search.
  SearchProgress(Progress* progress, bool linear) : progress_(progress), linear_(linear) {}

  // A search begins. It is never late before LimitTo.
  void Begin() noexcept {
    deadline_ = 0;
    begun_ = Clock::now();
    stopped_ = false;
    first_ = 0;
    done_ = 0;
    reported_ = std::chrono::steady_clock::now();
  }
  // Sets the deadline of the search, `deadline` [s] after its begin; 0: none. With a driven clock,
  // which no search advances, the deadline never passes, so that answers do not depend on the
  // machine.
  void LimitTo(double deadline) noexcept { deadline_ = deadline; }
  // Reports a solution with `residual` and the target `target`. The progress is measured on the
  // logarithm of the residual.
  void Reach(double residual, double target) noexcept {
    if (progress_ == nullptr || !(residual > 0) || !(target > 0)) return;
    first_ = std::max(first_, residual);
    const double digits = std::log(first_ / target);
    if (digits <= 0) return;
    done_ = std::max(done_, std::clamp(std::log(first_ / residual) / digits, 0., 1.));
  }
  // Reports the residual of an inner linear system.
  void ReachInner(double residual, double target) noexcept {
    if (linear_) Reach(residual, target);
  }
  // False: stop, now and until the next Begin.
  [[nodiscard]] bool Continue() noexcept {
    return ReportProgress("finding the equilibrium", done_);
  }
  // Reports that the share `done` of a factor is computed.
  [[nodiscard]] bool ContinueFactor(double done) noexcept {
    return ReportProgress("factoring the stiffness", done);
  }
  [[nodiscard]] bool stopped() const { return stopped_; }
  [[nodiscard]] bool late() const noexcept {
    return deadline_ > 0 && SecondsBetween(begun_, Clock::now()) > deadline_;
  }

 private:
  bool ReportProgress(const char* stage, double done) noexcept {
    if (progress_ == nullptr || stopped_ || DrivenClock::is_active()) return !stopped_;
    const auto now = std::chrono::steady_clock::now();
    if (now - reported_ < std::chrono::milliseconds(100)) return true;
    reported_ = now;
    try {
      stopped_ = !progress_->Report(stage, done);
    } catch (...) {  // a search whose report fails continues
    }
    return !stopped_;
  }

  Progress* progress_;
  bool linear_;
  bool stopped_ = false;
  double first_ = 0;  // residual of the search
  double done_ = 0;   // never falls
  std::chrono::steady_clock::time_point reported_;
  double deadline_ = 0;  // [s]
  Time begun_{};
};

}  // namespace palpate::fem
