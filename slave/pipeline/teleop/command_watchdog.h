// Looks after the operator's port every few milliseconds: the watchdog that holds the tool when
// commands stop, and the energies.
#pragma once

#include <functional>
#include <thread>

#include <Eigen/Core>

#include "slave/pipeline/teleop/operator_port.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

class CommandWatchdog {
 public:
  // `force` tells the force of the object on the tool, frame S [N]; thread-safe. Both must outlive
  // the watch, which ends with this object.
  CommandWatchdog(OperatorPort& port, std::function<Eigen::Vector3d()> force);

 private:
  std::jthread thread_;
};

// Throws std::logic_error: somebody follows, so a model must not change under the hand.
void RefuseWhileFollowing(const OperatorPort& port);
// Throws std::invalid_argument naming what is out of its range, and the range.
void CheckRanges(const ParameterChange& change);

}  // namespace palpate
