// Keeps a stream of the slave open for an observer: a separate thread reads messages, and reopens
// the stream with back-off when it ends.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "master/link/channel.h"
#include "master/link/status_words.h"

namespace palpate {

template <class Message>
class StreamKeeper {
 public:
  using Open = std::function<std::unique_ptr<grpc::ClientReader<Message>>(grpc::ClientContext*)>;
  using Take = std::function<void(const Message&)>;

  // Both are called on this object's thread and must outlive it.
  StreamKeeper(Open open, Take take)
      : open_(std::move(open)), take_(std::move(take)), thread_([this] { Run(); }) {}
  ~StreamKeeper() { Stop(); }
  StreamKeeper(const StreamKeeper&) = delete;
  StreamKeeper& operator=(const StreamKeeper&) = delete;

  // Why nothing is received; empty: no problem. Thread-safe.
  [[nodiscard]] std::string trouble() const {
    const std::scoped_lock lock(mutex_);
    return trouble_;
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
  static constexpr std::chrono::milliseconds kFirstRetry{100}, kLongestRetry{2000};

  void Run() {
    Backoff backoff(kFirstRetry, kLongestRetry);
    while (true) {
      if (Watch()) backoff.Reset();
      std::unique_lock lock(mutex_);
      if (stopped_.wait_for(lock, backoff.Next(), [this] { return stopping_; })) return;
    }
  }
  // Reads one stream until its end. True: a message was received.
  bool Watch() {
    grpc::ClientContext own;
    {
      const std::scoped_lock lock(mutex_);
      if (stopping_) return false;
      context_ = &own;
    }
    const auto stream = open_(&own);
    Message message;
    bool came = false;
    while (stream->Read(&message)) {
      take_(message);
      if (!std::exchange(came, true)) SetTrouble({});
    }
    const grpc::Status status = stream->Finish();
    SetTrouble(status.ok() ? "the slave ended the stream" : WordsOf(status));
    const std::scoped_lock lock(mutex_);
    context_ = nullptr;
    return came;
  }
  void SetTrouble(std::string trouble) {
    const std::scoped_lock lock(mutex_);
    trouble_ = std::move(trouble);
  }

  const Open open_;
  const Take take_;
  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable stopped_;
  bool stopping_ = false;
  grpc::ClientContext* context_ = nullptr;  // of the stream that is open
  std::string trouble_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace palpate
