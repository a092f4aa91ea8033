// The messages of one Operate stream, without its threads: which command is sent next, and which
// received state the haptic loop gets. A state arrives by the stream, by datagram or by both; the
// newer one counts. All times are on the master's clock.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "palpate/v1/state.pb.h"

#include "master/link/slave_link.h"
#include "master/link/state_record.h"
#include "shared/link/clock_offset.h"
#include "shared/link/latest_value.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/slave_state.h"
#include "shared/telemetry/latency_histogram.h"

namespace palpate {

// Round trips and clock offset from the echoes in states, and the echo in commands.
// Thread-safe, but not for the haptic loop.
class RoundTrips {
 public:
  // Resets for a new stream, whose slave may have another clock.
  void Restart();
  // Adds a state received at `received_at`, master's clock. Returns slave's minus master's clock
  // [s].
  double Arrived(const SlaveState& state, Time received_at);
  // Removes `state_sequence` and `echo` of a command if they are of a state that this stream has
  // not sent. Otherwise they are those of the haptic loop: the state that it used.
  void DropOtherEcho(OperatorCommand* command) const;

  // Times of all streams [us]. Those across both clocks use the offset known at that moment.
  struct Times {
    LatencyHistogram rtt;
    LatencyHistogram delay, age;   // of states at arrival, since sending and since sensing
    LatencyHistogram command_age;  // of the newest command when a state was sent
  };

  [[nodiscard]] double newest() const;  // [s]; 0: none yet
  [[nodiscard]] Times times() const;
  [[nodiscard]] double clock_offset() const;  // [s]

 private:
  mutable PriorityInheritanceMutex mutex_;  // guards everything below
  Times times_;
  double newest_ = 0;  // [s]
  ClockOffset offset_;
  std::uint64_t state_sequence_ = 0, command_sequence_ = 0;
};

class OperateExchange {
 public:
  // Objects that must outlive the exchange.
  struct Surroundings {
    LatestValue<ReceivedState>& states;
    LatestValue<OperatorCommand>& commands;
    RoundTrips& trips;
    std::atomic<std::uint64_t>& states_received;
    std::atomic<std::uint64_t>& states_by_datagram;  // states received first by datagram
    std::function<void()> on_first_state;
    std::function<void(const SlaveState&, const StateRecord&)> on_state;
    std::function<void(const std::string& reason)> on_refused_state;
  };

  // Discards a command of the previous stream.
  explicit OperateExchange(Surroundings surroundings);

  // The newest command of the haptic loop, stamped with `now`. nullopt: the loop has made none
  // since the last call; a command is not repeated, so that the slave notices a stopped loop. One
  // caller (the sender).
  std::optional<OperatorCommand> NextCommand(Time now);
  // Keeps and passes on a state that arrived at `now`. False: it is refused as invalid. One caller
  // each (the reader of the stream, the reader of datagrams).
  bool TakeFromStream(std::shared_ptr<v1::SlaveState> message, Time now);
  bool TakeDatagram(std::shared_ptr<v1::SlaveState> message, Time now);
  // The stream has ended: the haptic loop learns of it at once, and no later state is accepted.
  void End();
  // Returns whether a state arrived. Thread-safe.
  [[nodiscard]] bool was_served() const;

 private:
  // `state`: of `message`. False: it is older than the newest one. Requires mutex_.
  bool PutIfNewer(SlaveState state, std::shared_ptr<v1::SlaveState> message, Time now);

  const Surroundings with_;
  std::uint64_t stream_sequence_ = 0;       // used by the reader of the stream only
  mutable PriorityInheritanceMutex mutex_;  // guards the members below
  bool is_over_ = false;                    // no state is accepted any more
  std::uint64_t last_sequence_ = 0;
  ReceivedState last_;
  Events overtaken_;  // events of states that datagrams overtook; datagrams carry none
};

}  // namespace palpate
