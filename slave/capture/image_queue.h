// Passes images from the thread that reads them to the thread that uses them.
#pragma once

#include <cstddef>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/capture/frame_source.h"

namespace palpate {

// Thread-safe.
class ImageQueue {
 public:
  // Waits until fewer than `most` images wait to be taken; false: `stop`.
  bool Push(StereoPair images, std::size_t most, const std::stop_token& stop);
  // Discards those that wait: a live image is useful only while it is new.
  void Replace(StereoPair images);
  // Ends the queue. After the last image Take() throws `failure`, if there is one.
  void Close(std::exception_ptr failure);
  void Clear();
  [[nodiscard]] bool has_images() const {
    const std::lock_guard lock(mutex_);
    return !waiting_.empty();
  }

  // Waits for images; false: closed, or `stop`.
  bool Wait(const std::stop_token& stop);
  // Waits for the next images. nullopt: closed, or `stop`.
  std::optional<StereoPair> Take(const std::stop_token& stop);
  // Waits until `time` of the Clock, or for `stop`.
  void WaitUntil(Time time, const std::stop_token& stop);

 private:
  bool WaitLocked(std::unique_lock<PriorityInheritanceMutex>& lock, const std::stop_token& stop);

  mutable PriorityInheritanceMutex mutex_;  // guards the members below
  PriorityInheritanceCondition changed_;
  std::deque<StereoPair> waiting_;
  bool closed_ = false;
  std::exception_ptr failure_;
};

}  // namespace palpate
