// Checks whether the channels of a sensor without electrodes behave as in the training.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/signals/channel_pattern.h"
#include "slave/tactile/signals/tactile_signals.h"

namespace palpate {

// A channel is faulty if it differs from its prediction by the other channels, or jumps. A jump is
// a change between two samples that differs from the previous change and does not continue, whereas
// a contact continues. The channel remains faulty until it jumps back or is at rest.
class ChannelSignals {
 public:
  explicit ChannelSignals(std::shared_ptr<const ChannelPattern> pattern);

  // Processes the next sample. Allocation-free.
  void Update(const TactileSignals& change) noexcept;
  // Samples are missing before the next one.
  void Skip() noexcept { seen_ = 0; }
  void Reset() noexcept;

  // Returns the fault of a channel in the last sample as one clause; empty if there is none.
  [[nodiscard]] std::string_view fault() const noexcept { return fault_; }
  // Returns whether a channel is outside its range in the training, on the side of the contacts.
  [[nodiscard]] bool is_beyond() const noexcept { return is_beyond_; }
  // Returns whether a channel has moved to the other side, where contacts hardly move it.
  [[nodiscard]] bool is_opposite() const noexcept { return is_opposite_; }

 private:
  struct Channel {
    double pace = 0;        // usual change from sample to sample
    double jump = 0;        // unexplained change; 0: none
    bool is_fresh = false;  // the jump was that of the last sample
  };
  void CompareWithOthers() noexcept;
  void CompareWithRange() noexcept;
  void FindJumps() noexcept;

  std::shared_ptr<const ChannelPattern> pattern_;
  Eigen::VectorXd x_, last_, residual_;
  std::vector<Channel> channels_;
  int seen_ = 0;  // successive samples, up to 2
  std::string_view fault_;
  bool is_beyond_ = false, is_opposite_ = false;
};

}  // namespace palpate
