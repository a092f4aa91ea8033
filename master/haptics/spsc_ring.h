// A bounded queue between two threads, wait-free on both sides. The haptic loop writes its records
// into one. If the queue is full, the new value is dropped and counted.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// SpscRing is a queue for one writer thread and one reader thread. T is copied without allocating.
template <class T>
class SpscRing {
 public:
  explicit SpscRing(std::size_t capacity) : slots_(capacity + 1) {}

  bool Push(const T& value) noexcept {
    const std::size_t write = write_.load(std::memory_order_relaxed);
    const std::size_t next = (write + 1) % slots_.size();
    if (next == read_.load(std::memory_order_acquire)) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[write] = value;
    write_.store(next, std::memory_order_release);
    return true;
  }
  bool Pop(T* value) noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (read == write_.load(std::memory_order_acquire)) return false;
    *value = slots_[read];
    read_.store((read + 1) % slots_.size(), std::memory_order_release);
    return true;
  }
  [[nodiscard]] std::uint64_t dropped() const noexcept {
    return dropped_.load(std::memory_order_relaxed);
  }

 private:
  std::vector<T> slots_;
  std::atomic<std::size_t> write_{0}, read_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace palpate
