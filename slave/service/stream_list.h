// The open streams of one kind, so that all of them end when the slave stops.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "palpate/v1/telemetry.pb.h"

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"

namespace palpate {

// Identifies a sender or driver: no other stream of this program has the number.
inline std::uint64_t NewStreamId() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

// Thread-safe. `Stream` has Close().
template <class Stream>
class StreamList {
 public:
  // False: closed already.
  bool Add(const std::shared_ptr<Stream>& stream) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(streams_, [](const auto& other) { return other.expired(); });
    if (!closed_) streams_.push_back(stream);
    return !closed_;
  }
  // Closes present and future streams.
  void Close() {
    std::vector<std::weak_ptr<Stream>> streams;
    {
      const std::scoped_lock lock(mutex_);
      closed_ = true;
      streams.swap(streams_);
    }
    for (const auto& weak : streams) {
      if (const auto stream = weak.lock()) stream->Close();
    }
  }

 private:
  PriorityInheritanceMutex mutex_;  // guards the members below
  std::vector<std::weak_ptr<Stream>> streams_;
  bool closed_ = false;
};

// The streams that were refused within the last minute, for Status.alarms. Thread-safe.
class RefusedStreams {
 public:
  void Add(const std::string& call, const std::string& client, const std::string& why) {
    const std::scoped_lock lock(mutex_);
    newest_.emplace_front(call + " of " + client + " was refused: " + why, Clock::now());
    if (newest_.size() > kMaxKept) newest_.pop_back();
  }
  void FillStatus(v1::Status* status) const {
    const std::scoped_lock lock(mutex_);
    for (const auto& [words, at] : newest_) {
      if (SecondsBetween(at, Clock::now()) < kReported) status->add_alarms(words);
    }
  }

 private:
  static constexpr std::size_t kMaxKept = 16;
  static constexpr double kReported = 60;  // [s]

  mutable PriorityInheritanceMutex mutex_;  // guards the member below
  std::deque<std::pair<std::string, Time>> newest_;
};

}  // namespace palpate
