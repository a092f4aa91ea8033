// One Operate stream from its opening to its end, commands up at 500 Hz, states down as they come,
// and what its echoes tell. Where it is wished and offered, the same also by datagram: the stream
// opens and ends that way, and what is newer counts, whichever way it came.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/newest_writer.h"
#include "master/link/slave_link.h"
#include "shared/link/clock_offset.h"
#include "shared/link/datagram_line.h"
#include "shared/link/latest_value.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/slave_state.h"
#include "shared/telemetry/latency_histogram.h"
#include "shared/tls/certificate.h"

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

  // Of all streams [us]; what two clocks are needed for by the offset known then.
  struct Times {
    LatencyHistogram rtt;
    LatencyHistogram delay, age;   // of states, when they came, since they left and were sensed
    LatencyHistogram command_age;  // of the newest command taken, when a state left
  };

  [[nodiscard]] double newest() const;  // [s]; 0: none came back yet
  [[nodiscard]] Times times() const;
  [[nodiscard]] double clock_offset() const;  // [s]

 private:
  mutable std::mutex mutex_;  // guards everything below
  Times times_;
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
    std::atomic<std::uint64_t>& states_by_datagram;  // that came so before they came by the stream
    std::atomic<Time>& datagram_at;                  // when the last came
  };

  // `datagrams`: the slave is asked for them.
  OperateSession(Surroundings surroundings, std::string operator_name,
                 std::chrono::milliseconds first_within,
                 std::chrono::milliseconds longest_round_trip, bool datagrams)
      : with_(std::move(surroundings)),
        operator_name_(std::move(operator_name)),
        first_within_(first_within),
        silence_(std::max<std::chrono::milliseconds>(kSilence, longest_round_trip)),
        datagrams_requested_(datagrams) {}

  // Blocks until the stream ends: by the slave, by silence, as its certificate holds no longer, by
  // `stop` (then the slave is told and ends it) or by Cancel. How it ended.
  grpc::Status Run(const std::stop_token& stop);
  // Cuts the stream without waiting for the slave. Any thread.
  void Cancel() { context_.TryCancel(); }
  // The slave answered at least once.
  [[nodiscard]] bool was_served() const { return last_sequence_ != 0; }

 private:
  using Stream = grpc::ClientReaderWriter<v1::OperatorCommand, v1::SlaveState>;

  void SendCommands(Stream* stream, const std::stop_token& stop);
  // Cuts the stream where it is to go on no longer; false: it is cut.
  bool MayGoOn(Time now);
  void SendNewest(Stream* stream);
  void ReceiveFromStream(const v1::SlaveState& message);
  DatagramLine::LinkFeedback ReceiveDatagram(std::string_view plain);
  void OpenDatagrams(const v1::DatagramOffer& offer);
  // Whichever way it came; false: it is not. With mutex_ held, as the next one.
  bool TakeIfNewer(const SlaveState& state, Time now);
  void Put(ReceivedState received);

  const Surroundings with_;
  const std::string operator_name_;
  const std::chrono::milliseconds first_within_, silence_;
  const bool datagrams_requested_;
  grpc::ClientContext context_;
  std::atomic<Time> heard_at_{Clock::now()};  // a state that could be used
  std::atomic<bool> silent_{false}, expired_{false};
  std::atomic<WallTime> trusted_until_{WallTime::max()};  // by the slave's certificate
  std::uint64_t commands_ = 0;                            // the sender's own, as are the next two
  v1::OperatorCommand message_;
  std::optional<NewestWriter<v1::OperatorCommand, Stream>> writer_;  // once there are datagrams
  std::uint64_t stream_sequence_ = 0;                                // the reader's own
  v1::SlaveState datagram_;                // the datagram line's thread's own
  PriorityInheritanceMutex mutex_;         // guards what follows, while there are several threads
  std::unique_ptr<DatagramLine> line_;     // outlives the sender; null: none
  bool served_ = false, is_over_ = false;  // the latter: nothing is taken any more
  std::uint64_t last_sequence_ = 0;
  ReceivedState last_;
  // Of states that the loop never took; of those that datagrams overtook, for the next one.
  Events untaken_, overtaken_;
};

}  // namespace palpate
