// Keeps a stream of the slave open for an observer: a separate thread reads messages, and reopens
// the stream with back-off when it ends. Only a slave that does not have the call (UNIMPLEMENTED)
// ends it permanently: a restart or another scene may change all other reasons.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/channel.h"
#include "master/link/slave_link.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/link/thread_priority.h"

namespace palpate {

// Opens a separate connection for observers. Throws std::invalid_argument for an invalid target, or
// one beyond loopback without `insecure`.
inline std::unique_ptr<v1::Teleoperation::Stub> BulkStub(const SlaveLink::Options& link) {
  return v1::Teleoperation::NewStub(
      OpenChannel(PermittedTarget(link.target, link.insecure || !link.tls.empty()), Traffic::kBulk,
                  link.tls, link.max_round_trip));
}

// Makes one call with an empty request and a deadline of a second, which `stop` cancels.
template <class Request, class Reply>
grpc::Status Query(v1::Teleoperation::Stub* stub,
                   grpc::Status (v1::Teleoperation::Stub::*call)(grpc::ClientContext*,
                                                                 const Request&, Reply*),
                   const std::stop_token& stop, Reply* reply) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(1));
  const ReadingPriority reading;
  const std::stop_callback cancel(stop, [&context] { context.TryCancel(); });
  return (stub->*call)(&context, Request(), reply);
}

template <class Message>
class StreamKeeper {
 public:
  using Open = std::function<std::unique_ptr<grpc::ClientReader<Message>>(grpc::ClientContext*)>;
  // Returns why the message is rejected; empty: it is accepted. May modify the message.
  using Take = std::function<std::string(Message*)>;

  struct Stats {
    std::uint64_t accepted = 0, rejected = 0;  // received messages
    std::string trouble;  // why none is received, or why the last one was rejected; empty: neither
  };

  // Both functions are called on this object's thread and must outlive it, the second at ordinary
  // priority.
  StreamKeeper(Open open, Take take)
      : open_(std::move(open)), take_(std::move(take)), thread_([this] { Run(); }) {}
  ~StreamKeeper() { Stop(); }
  StreamKeeper(const StreamKeeper&) = delete;
  StreamKeeper& operator=(const StreamKeeper&) = delete;

  [[nodiscard]] Stats stats() const {  // thread-safe
    const std::scoped_lock lock(mutex_);
    return stats_;
  }
  // Ends the open stream; the next one starts again.
  void Reopen() {
    const std::scoped_lock lock(mutex_);
    if (context_ != nullptr) context_->TryCancel();
  }
  // Ends the stream.
  void Stop() {
    {
      const std::scoped_lock lock(mutex_);
      stopping_ = true;
      if (context_ != nullptr) context_->TryCancel();
    }
    stopped_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

 private:
  static constexpr std::chrono::milliseconds kFirstRetry{100}, kMaxRetry{2000};

  void Run() {
    Backoff backoff(kFirstRetry, kMaxRetry);
    while (Watch(&backoff)) {
      std::unique_lock lock(mutex_);
      const auto due = std::chrono::steady_clock::now() + backoff.Next();
      if (stopped_.wait_until(lock, due, [this] { return stopping_; })) return;
    }
  }
  // Reads one stream until its end. False: no other follows.
  bool Watch(Backoff* backoff) {
    grpc::ClientContext own;
    {
      const std::scoped_lock lock(mutex_);
      if (stopping_) return false;
      context_ = &own;
    }
    const ReadingPriority reading;
    const auto stream = open_(&own);
    Message message;
    bool is_rejected = false;
    while (stream->Read(&message)) {
      std::string trouble = TakeUnhurried(&message);
      is_rejected = !trouble.empty();
      if (!is_rejected) backoff->Reset();
      const std::scoped_lock lock(mutex_);
      ++(is_rejected ? stats_.rejected : stats_.accepted);
      stats_.trouble = std::move(trouble);
    }
    const grpc::Status status = stream->Finish();
    const std::scoped_lock lock(mutex_);
    context_ = nullptr;
    if (!stopping_ && !is_rejected) {
      stats_.trouble = status.ok() ? "the slave ended the stream" : WordsOf(status);
    }
    return status.error_code() != grpc::StatusCode::UNIMPLEMENTED;
  }

  std::string TakeUnhurried(Message* message) {
    const OrdinaryPriority ordinary;
    return take_(message);
  }

  const Open open_;
  const Take take_;
  mutable PriorityInheritanceMutex mutex_;  // guards the members below
  PriorityInheritanceCondition stopped_;
  bool stopping_ = false;
  grpc::ClientContext* context_ = nullptr;  // of the stream that is open
  Stats stats_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace palpate
