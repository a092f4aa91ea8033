// Mailbox of one reader: a single slot with the newest state. No event is lost.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

#include "shared/state/slave_state.h"

namespace palpate {

// Thread-safe, with fixed memory. Real-time threads use LatestValue instead.
class StateMailbox {
 public:
  // Replaces the waiting state and adds its events to the new one.
  void Put(const SlaveState& state) {
    {
      const std::scoped_lock lock(mutex_);
      const Events skipped = slot_ ? slot_->events : Events{};
      slot_ = state;
      slot_->events.Add(skipped);
    }
    changed_.notify_one();
  }
  // The newest state not yet taken; nullopt: nothing new.
  std::optional<SlaveState> TakeNewest() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(slot_, std::nullopt);
  }
  // Like TakeNewest, but waits. nullopt: none within `patience`, or closed.
  std::optional<SlaveState> WaitNewest(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [this] { return slot_ || closed_; });
    return closed_ ? std::nullopt : std::exchange(slot_, std::nullopt);
  }
  // Sleeps until `due` or until closed, even if states arrive.
  void PauseUntil(Time due) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, Clock::ToSteady(due), [this] { return closed_; });
  }
  // Closes the mailbox and wakes waiting threads.
  void Close() {
    {
      const std::scoped_lock lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
  }
  [[nodiscard]] bool closed() const {
    const std::scoped_lock lock(mutex_);
    return closed_;
  }

 private:
  mutable std::mutex mutex_;  // guards slot_ and closed_
  std::condition_variable changed_;
  std::optional<SlaveState> slot_;
  bool closed_ = false;
};

}  // namespace palpate
