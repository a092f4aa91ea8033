// One Operate stream from its opening to its end, commands up at 500 Hz, states down as they come,
// and what its echoes tell.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/slave_link.h"
#include "shared/link/clock_offset.h"
#include "shared/link/latest_value.h"
#include "shared/state/slave_state.h"
#include "shared/telemetry/latency_histogram.h"

namespace palpate {

// What the states' echoes tell about the line: round trips, the other clock, and what the next
// command has to echo. Thread-safe; not for the haptic loop.
class RoundTrips {
 public:
  // A new stream: the slave's clock may be another one.
  void Restart();
  // A state came at `received_at`, master's clock. Returns the slave's clock minus ours [s].
  double Arrived(const SlaveState& state, Time received_at);
  // Fills `state_sequence` and `echo` of a command that is about to leave.
  void FillEcho(OperatorCommand* command) const;

  [[nodiscard]] double newest() const;         // [s]; 0: none came back yet
  [[nodiscard]] LatencyHistogram rtt() const;  // of all streams [us]
  [[nodiscard]] double clock_offset() const;   // [s]

 private:
  mutable std::mutex mutex_;  // guards everything below
  LatencyHistogram rtt_;
  double newest_ = 0;  // [s]
  ClockOffset offset_;
  std::uint64_t state_sequence_ = 0, command_sequence_ = 0;
  std::optional<Time> echo_;
};

class OperateSession {
 public:
  static constexpr std::chrono::microseconds kCommandPeriod{2000};
  // A stream without any state for so long, or for the longest round trip reckoned with, is given
  // up: its line was cut without a word. The first one may take longer by `first_within`.
  static constexpr std::chrono::seconds kSilence{2};

  // What outlives the session.
  struct Surroundings {
    v1::Teleoperation::Stub& stub;
    LatestValue<ReceivedState>& states;
    LatestValue<OperatorCommand>& commands;
    RoundTrips& trips;
    std::atomic<std::uint64_t>& states_received;
    std::atomic<std::uint64_t>& commands_sent;
    std::function<void()> on_first_state;
    std::function<void(std::uint32_t settings_revision)> on_state;
    std::function<void(const std::string& reason)> on_refused_state;
    std::function<void(const ReceivedState&)> on_received;  // may be empty, as the next one
    std::function<void(const OperatorCommand&)> on_sent;
  };

  OperateSession(Surroundings surroundings, std::string operator_name,
                 std::chrono::milliseconds first_within,
                 std::chrono::milliseconds longest_round_trip)
      : with_(std::move(surroundings)),
        operator_name_(std::move(operator_name)),
        first_within_(first_within),
        silence_(std::max<std::chrono::milliseconds>(kSilence, longest_round_trip)) {}

  // Blocks until the stream ends: by the slave, by silence, by `stop` (then the slave is told and
  // ends it) or by Cancel. How it ended.
  grpc::Status Run(const std::stop_token& stop);
  // Cuts the stream without waiting for the slave. Any thread.
  void Cancel() { context_.TryCancel(); }
  // The slave answered at least once.
  [[nodiscard]] bool was_served() const { return last_sequence_ != 0; }

 private:
  using Stream = grpc::ClientReaderWriter<v1::OperatorCommand, v1::SlaveState>;

  void SendCommands(Stream* stream, const std::stop_token& stop);
  void SendNewest(Stream* stream);
  void Receive(const v1::SlaveState& message);
  void Put(ReceivedState received);

  const Surroundings with_;
  const std::string operator_name_;
  const std::chrono::milliseconds first_within_, silence_;
  grpc::ClientContext context_;
  std::atomic<Time> heard_at_{Clock::now()};  // a state that could be used
  std::atomic<bool> silent_{false};
  std::uint64_t commands_ = 0;   // the sender's own
  v1::OperatorCommand message_;  // the sender's own
  bool served_ = false;          // the reader's own, as is what follows
  std::uint64_t last_sequence_ = 0;
  ReceivedState last_;
  Events untaken_;
};

}  // namespace palpate
