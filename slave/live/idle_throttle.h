// Slows the sensing thread down while no client watches.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <stop_token>

#include "shared/link/priority_inheritance_mutex.h"

namespace palpate {

class IdleThrottle {
 public:
  static constexpr std::chrono::milliseconds kIdlePeriod{
      500};  // of the samples without a watching client

  // Permits the thread to skip samples from now on. The sensing must recover its state in one
  // sample.
  void Allow() { is_allowed_ = true; }
  [[nodiscard]] bool is_allowed() const { return is_allowed_; }
  // The sensing thread calls it after each sample. It waits for a watching client, for `Wake` or
  // for the time of the next idle sample. `report` is called with the length of the wait [s], 0
  // without one.
  template <class Report>
  void Wait(const std::stop_token& stop, const Report& report) {
    if (!is_allowed_) return;
    std::unique_lock lock(mutex_);
    report(is_watched_ ? 0 : std::chrono::duration<double>(kIdlePeriod).count());
    woken_.wait_until(lock, stop, std::chrono::steady_clock::now() + kIdlePeriod,
                      [this] { return is_watched_ || is_woken_; });
    is_woken_ = false;
  }
  void SetWatched(bool is_watched) {
    {
      const std::lock_guard lock(mutex_);
      is_watched_ = is_watched;
    }
    if (is_watched && is_allowed_) woken_.notify_all();
  }
  // Ends the present wait.
  void Wake() {
    {
      const std::lock_guard lock(mutex_);
      is_woken_ = true;
    }
    woken_.notify_all();
  }

 private:
  std::atomic<bool> is_allowed_{false};
  PriorityInheritanceMutex mutex_;  // guards the next three
  PriorityInheritanceCondition woken_;
  bool is_watched_ = true, is_woken_ = false;
};

}  // namespace palpate
