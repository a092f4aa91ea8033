// Mailbox of one reader: a single slot with the newest state. No event is lost.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/slave_state.h"

namespace palpate {

// Thread-safe, with fixed memory. The writer may be more urgent than the reader: it does not wait
// for the reader's turn on the processor. The haptic loop uses LatestValue instead.
class StateMailbox {
 public:
  // Replaces the waiting state and adds its events to the new one. Wakes no paused reader.
  void Put(const SlaveState& state) {
    bool is_awaited = false;
    {
      const std::scoped_lock lock(mutex_);
      const Events skipped = slot_ ? slot_->events : Events{};
      slot_ = state;
      slot_->events.Add(skipped);
      is_awaited = is_awaited_;
    }
    if (is_awaited) changed_.notify_one();
  }
  // Returns the newest state that was not taken yet; nullopt: no new state.
  std::optional<SlaveState> TakeNewest() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(slot_, std::nullopt);
  }
  // As TakeNewest, but waits. nullopt: no state arrived within `timeout`, or the box is closed.
  std::optional<SlaveState> WaitNewest(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    is_awaited_ = true;
    changed_.wait_until(lock, std::chrono::steady_clock::now() + timeout,
                        [this] { return slot_ || closed_; });
    is_awaited_ = false;
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
  mutable PriorityInheritanceMutex mutex_;  // guards the members below
  PriorityInheritanceCondition changed_;
  std::optional<SlaveState> slot_;
  bool is_awaited_ = false;  // a reader waits in WaitNewest
  bool closed_ = false;
};

}  // namespace palpate
