// The open streams of one kind, so that all of them end when the slave stops.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

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
  std::mutex mutex_;  // guards the members below
  std::vector<std::weak_ptr<Stream>> streams_;
  bool closed_ = false;
};

}  // namespace palpate
