// OperateSession runs one Operate stream from its opening to its end. It sends commands at 500 Hz,
// receives states and evaluates their echoes. If both ends allow it, the same messages also travel
// as datagrams. The stream begins and ends the datagrams, and the newer message counts.
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
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/operate_exchange.h"
#include "shared/link/datagram_line.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/link/thread_priority.h"
#include "shared/state/slave_state.h"
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
    MakeThreadRealtime(kReadingPriority);
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
  PriorityInheritanceMutex mutex_;  // guards the next two
  PriorityInheritanceCondition changed_;
  std::optional<Message> slot_;
  std::jthread thread_;  // last: it uses all of the above
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
    OperateExchange::Surroundings exchange;
    std::atomic<std::uint64_t>& commands_sent;
    std::atomic<Time>& datagram_at;                       // arrival of the last datagram
    std::function<void(const OperatorCommand&)> on_sent;  // may be empty
  };

  // What this stream requests of the slave, see OperatorCommand.
  struct Requests {
    bool datagrams = false, details = false;
  };
  OperateSession(Surroundings surroundings, std::string operator_name,
                 std::chrono::milliseconds first_within, std::chrono::milliseconds max_round_trip,
                 const Requests& requests)
      : with_(std::move(surroundings)),
        operator_name_(std::move(operator_name)),
        first_within_(first_within),
        silence_(std::max<std::chrono::milliseconds>(kSilence, max_round_trip)),
        requests_(requests),
        exchange_(with_.exchange) {}

  // Blocks until the stream ends and returns its status. It ends by the slave, by silence, by an
  // invalid certificate, by `stop` (the slave is informed and ends it) or by Cancel.
  grpc::Status Run(const std::stop_token& stop);
  // Cancels the stream without waiting for the slave. Thread-safe.
  void Cancel() { context_.TryCancel(); }
  // Returns whether the slave answered at least once.
  [[nodiscard]] bool was_served() const { return exchange_.was_served(); }

 private:
  using Stream = grpc::ClientReaderWriter<v1::OperatorCommand, v1::SlaveState>;

  void SendCommands(Stream* stream, const std::stop_token& stop);
  // Cancels the stream if it must not continue; false: cancelled.
  bool MayGoOn(Time now);
  void SendNewest(Stream* stream);
  void ReceiveFromStream(std::shared_ptr<v1::SlaveState> message);
  DatagramLine::LinkFeedback ReceiveDatagram(std::string_view plain);
  void OpenDatagrams(const v1::DatagramOffer& offer);

  const Surroundings with_;
  const std::string operator_name_;
  const std::chrono::milliseconds first_within_, silence_;
  const Requests requests_;
  OperateExchange exchange_;
  grpc::ClientContext context_;
  std::atomic<Time> received_at_{Clock::now()};  // arrival of the last valid state of the stream
  std::atomic<bool> silent_{false}, expired_{false};
  std::atomic<WallTime> trusted_until_{WallTime::max()};  // expiry of the slave's certificate
  bool is_introduced_ = false;  // used by the sender only, like the next two
  v1::OperatorCommand message_;
  std::optional<NewestWriter<v1::OperatorCommand, Stream>> writer_;  // set while datagrams are used
  PriorityInheritanceMutex mutex_;                                   // guards the members below
  std::unique_ptr<DatagramLine> line_;  // outlives the sender; null: none
};

}  // namespace palpate
