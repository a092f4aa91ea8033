// Copies of a recurrent network that take the same samples and differ in when they began: one for
// each window that a sample belongs to. All of them advance together, and each sample goes through
// the input weights once.
#pragma once

#include <memory>
#include <vector>

#include "slave/tactile/network/lstm_plan.h"

namespace palpate {

// Real-time safe once constructed.
class LstmLanes {
 public:
  LstmLanes(std::shared_ptr<const LstmPlan> plan, int lanes);

  // The state of zero, for all lanes or for one.
  void Restart() noexcept;
  void Restart(int lane) noexcept;
  // All lanes take the next sample: counts minus rest, the network's inputs of them finite.
  void Step(const TactileSignals& change) noexcept;
  // The last layer's h of a lane, one number per unit.
  void Output(int lane, double* h) const noexcept;

 private:
  struct State {
    CacheLines own, next, cell;  // units x stride
  };

  std::shared_ptr<const LstmPlan> plan_;
  long stride_;
  CacheLines projected_;
  std::vector<State> states_;  // one per layer
};

}  // namespace palpate
