// What the states' echoes tell about the line: round trips, the other clock, and what the next
// command has to echo.
#pragma once

#include <mutex>

#include "shared/link/clock_offset.h"
#include "shared/state/slave_state.h"
#include "shared/telemetry/latency_histogram.h"

namespace palpate {

// Thread-safe; not for the haptic loop.
class RoundTrips {
 public:
  // A new stream: the slave's clock may be another one.
  void Restart();
  // A state came at `received_at`, master's clock. Returns the slave's clock minus ours [s].
  double Arrived(const SlaveState& state, Time received_at);
  // Fills `state_sequence` and `echo` of a command that is about to leave.
  void FillEcho(OperatorCommand* command) const;

  [[nodiscard]] LatencyHistogram rtt() const;  // of all streams [us]
  [[nodiscard]] double clock_offset() const;   // [s]

 private:
  mutable std::mutex mutex_;  // guards everything below
  LatencyHistogram rtt_;
  ClockOffset offset_;
  std::uint64_t state_sequence_ = 0, command_sequence_ = 0;
  std::optional<Time> echo_;
};

}  // namespace palpate
