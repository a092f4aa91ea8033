// A simulated operator of a slave in the same process.
#pragma once

#include <algorithm>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "slave/live/slave.h"

namespace palpate {

// On a busy machine the tool may be held at any time. Like a person, the operator then engages
// again with a new epoch and continues from the tool's position.
class EngagedHand {
 public:
  explicit EngagedHand(Slave* slave)
      : slave_(*slave), transform_(slave->Describe().scene.operator_options.transform) {
    command_.epoch = 1;
  }

  // The next command begins another engagement.
  void Engage() { ++command_.epoch; }
  // Sends the present position again. Returns the following state.
  SlaveState Stay(bool engaged = true) {
    ++command_.sequence;
    command_.sent_at = Clock::now();
    command_.engaged = engaged;
    EXPECT_TRUE(slave_.Command(command_));
    const SlaveState state = slave_.Compose(Clock::now());
    if (engaged && state.phase == Phase::kHold) Engage();
    return state;
  }
  // Moves the commanded position towards tool position `p_S` by at most `step` [m] and sends it.
  SlaveState GoTo(const Eigen::Vector3d& p_S, double step) {
    const SlaveState state = Stay();
    if (state.phase != Phase::kFollowing) return state;
    transform_.offset = state.offset;
    const Eigen::Vector3d target = transform_.ToSlave(command_.p_M), way = p_S - target;
    command_.p_M = transform_.ToMaster(target + std::min(1.0, step / way.norm()) * way);
    return state;
  }
  // The target of the tool for the present place, frame S [m].
  [[nodiscard]] Eigen::Vector3d target() const { return transform_.ToSlave(command_.p_M); }

 private:
  Slave& slave_;
  TeleopTransform transform_;
  OperatorCommand command_;
};

}  // namespace palpate
