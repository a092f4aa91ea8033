// One Operate stream from its opening to its end: sends commands at 500 Hz, receives states and
// evaluates their echoes. If both ends allow it, the same messages also travel as datagrams. The
// stream begins and ends the datagrams, and the newer message counts.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/slave_link.h"
#include "shared/link/clock_offset.h"
#include "shared/link/datagram_line.h"
#include "shared/link/latest_value.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/link/thread_priority.h"
#include "shared/state/slave_state.h"
#include "shared/telemetry/latency_histogram.h"
#include "shared/tls/credentials.h"

namespace palpate {

// Writes to a stream on a separate thread, so that a stalled stream blocks no other thread.
// `Stream` has Write(Message), which may block and which no other thread calls.
template <class Message, class Stream>
class NewestWriter {
 public:
  // `on_written`: called after each message on the writer's thread.
  NewestWriter(Stream* stream, std::function<void()> on_written)
      : stream_(stream),
        on_written_(std::move(on_written)),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  // Replaces a message that is not written yet.
  void Put(const Message& message) {
    {
      const std::scoped_lock lock(mutex_);
      slot_ = message;
    }
    changed_.notify_one();
  }

 private:
  void Run(const std::stop_token& stop) {
    MakeThreadRealtime(kLinkPriority);
    while (true) {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return slot_.has_value(); })) return;
      const Message message = *std::exchange(slot_, std::nullopt);
      lock.unlock();
      if (!stream_->Write(message)) return;
      on_written_();
    }
  }

  Stream* const stream_;
  const std::function<void()> on_written_;
  std::mutex mutex_;  // guards the next two
  std::condition_variable_any changed_;
  std::optional<Message> slot_;
  std::jthread thread_;  // last: it uses all of the above
};

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
  mutable std::mutex mutex_;  // guards everything below
  Times times_;
  double newest_ = 0;  // [s]
  ClockOffset offset_;
  std::uint64_t state_sequence_ = 0, command_sequence_ = 0;
};

class OperateSession {
 public:
  static constexpr std::chrono::microseconds kCommandPeriod{2000};
  // A stream without a state for this time, or for the longest round trip, is closed, because its
  // link may be cut. The first state may take longer by `first_within`.
  static constexpr std::chrono::seconds kSilence{2};

  // Objects that must outlive the session.
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
    std::function<void(const ReceivedState&)> on_received;  // may be empty, like the next one
    std::function<void(const OperatorCommand&)> on_sent;
    std::atomic<std::uint64_t>& states_by_datagram;  // states received first by datagram
    std::atomic<Time>& datagram_at;                  // arrival of the last datagram
  };

  // `datagrams`: request them from the slave.
  OperateSession(Surroundings surroundings, std::string operator_name,
                 std::chrono::milliseconds first_within,
                 std::chrono::milliseconds longest_round_trip, bool datagrams)
      : with_(std::move(surroundings)),
        operator_name_(std::move(operator_name)),
        first_within_(first_within),
        silence_(std::max<std::chrono::milliseconds>(kSilence, longest_round_trip)),
        datagrams_requested_(datagrams) {}

  // Blocks until the stream ends and returns its status. It ends by the slave, by silence, by an
  // invalid certificate, by `stop` (the slave is informed and ends it) or by Cancel.
  grpc::Status Run(const std::stop_token& stop);
  // Cancels the stream without waiting for the slave. Thread-safe.
  void Cancel() { context_.TryCancel(); }
  // Whether the slave answered at least once.
  [[nodiscard]] bool was_served() const { return last_sequence_ != 0; }

 private:
  using Stream = grpc::ClientReaderWriter<v1::OperatorCommand, v1::SlaveState>;

  void SendCommands(Stream* stream, const std::stop_token& stop);
  // Cancels the stream if it must not continue; false: cancelled.
  bool MayGoOn(Time now);
  void SendNewest(Stream* stream);
  void ReceiveFromStream(const v1::SlaveState& message);
  DatagramLine::LinkFeedback ReceiveDatagram(std::string_view plain);
  void OpenDatagrams(const v1::DatagramOffer& offer);
  // Accepts a state of stream or datagram; false: it is older. Requires mutex_, like the next one.
  bool TakeIfNewer(const SlaveState& state, Time now);
  void Put(ReceivedState received);

  const Surroundings with_;
  const std::string operator_name_;
  const std::chrono::milliseconds first_within_, silence_;
  const bool datagrams_requested_;
  grpc::ClientContext context_;
  std::atomic<Time> heard_at_{Clock::now()};  // arrival of the last valid state
  std::atomic<bool> silent_{false}, expired_{false};
  std::atomic<WallTime> trusted_until_{WallTime::max()};  // expiry of the slave's certificate
  bool is_introduced_ = false;  // used by the sender only, like the next two
  v1::OperatorCommand message_;
  std::optional<NewestWriter<v1::OperatorCommand, Stream>> writer_;  // set while datagrams are used
  std::uint64_t stream_sequence_ = 0;                                // used by the reader only
  v1::SlaveState datagram_;                // used by the datagram thread only
  PriorityInheritanceMutex mutex_;         // guards what follows
  std::unique_ptr<DatagramLine> line_;     // outlives the sender; null: none
  bool served_ = false, is_over_ = false;  // is_over_: no state is accepted any more
  std::uint64_t last_sequence_ = 0;
  ReceivedState last_;
  // Events of states that the haptic loop skipped, and of states that datagrams overtook.
  Events untaken_, overtaken_;
};

}  // namespace palpate
