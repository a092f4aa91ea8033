// Passes the newest value between two threads, wait-free on both sides: a triple buffer. The haptic
// loop exchanges data through these.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace palpate {

// LatestValue passes the newest value from one writer thread to one reader thread. T is copied; it
// must not allocate when copied if either side is real-time.
template <class T>
class LatestValue {
 public:
  // Writer: publishes a copy of `value`. Never waits.
  void Put(const T& value) noexcept {
    slots_[write_] = value;
    write_ = middle_.exchange(write_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }
  // Reader: the newest value not yet taken, or nullptr. Valid until the next Take.
  const T* Take() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return nullptr;
    read_ = middle_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    return &slots_[read_];
  }

 private:
  static constexpr std::uint8_t kFresh = 4, kIndex = 3;
  std::array<T, 3> slots_{};
  std::atomic<std::uint8_t> middle_{1};
  std::uint8_t write_ = 0;  // slot of the writer
  std::uint8_t read_ = 2;   // slot of the reader
};

}  // namespace palpate
