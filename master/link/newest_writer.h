// Writes to a stream on a separate thread, so that a stalled stream blocks no other thread.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include "shared/link/thread_priority.h"

namespace palpate {

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

}  // namespace palpate
