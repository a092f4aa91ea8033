// Lets the sensing thread rest while no client watches.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <stop_token>

#include "shared/link/priority_inheritance_mutex.h"

namespace palpate {

class ObserverRest {
 public:
  static constexpr std::chrono::milliseconds kNap{500};  // without a watching client

  // From now on the thread rests: only for sensing that recovers its state in one sample.
  void Allow() { is_allowed_ = true; }
  [[nodiscard]] bool is_allowed() const { return is_allowed_; }
  // The sensing thread: waits for a watching client, for `Rouse`, or for the time of the next
  // sample without one. `tell`: called with the length of the rest [s]; 0: none.
  template <class Tell>
  void Wait(const std::stop_token& stop, const Tell& tell) {
    if (!is_allowed_) return;
    std::unique_lock lock(mutex_);
    tell(is_watched_ ? 0 : std::chrono::duration<double>(kNap).count());
    roused_.wait_until(lock, stop, std::chrono::steady_clock::now() + kNap,
                       [this] { return is_watched_ || is_roused_; });
    is_roused_ = false;
  }
  void SetWatched(bool is_watched) {
    {
      const std::lock_guard lock(mutex_);
      is_watched_ = is_watched;
    }
    if (is_watched && is_allowed_) roused_.notify_all();
  }
  // Ends a rest now.
  void Rouse() {
    {
      const std::lock_guard lock(mutex_);
      is_roused_ = true;
    }
    roused_.notify_all();
  }

 private:
  std::atomic<bool> is_allowed_{false};
  PriorityInheritanceMutex mutex_;  // guards the next three
  PriorityInheritanceCondition roused_;
  bool is_watched_ = true, is_roused_ = false;
};

}  // namespace palpate
