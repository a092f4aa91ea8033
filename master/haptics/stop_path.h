// Sends the emergency stop to the slave on separate threads: in every command of the haptic loop,
// and by a call of Stop, which also works without operating.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <utility>

#include "master/haptics/received.h"
#include "shared/state/clock.h"

namespace palpate {

// `Request` and `Act` are thread-safe, `Request` is safe in signal handlers too. The haptic loop
// calls the others. Wait-free.
class StopRequests {
 public:
  // Requests the emergency stop.
  void Request() noexcept { ++asked_; }
  // Confirms the first `count` requests: the slave has made the emergency stop `number`, which a
  // state reports later.
  void Act(std::uint32_t count, std::uint64_t number) noexcept {
    Raise(&number_, number);
    Raise(&acted_, count);
  }
  // Number of requested stops, and whether one is not confirmed yet.
  [[nodiscard]] std::uint32_t asked() const noexcept { return asked_; }
  [[nodiscard]] bool is_wanted() const noexcept { return asked_ != acted_; }

  // Adds the request to the next command.
  void Put(OperatorCommand* command) noexcept {
    const std::uint32_t asked = asked_;
    if (std::exchange(put_, asked) != asked) sequence_ = command->sequence;
    command->stop = asked != acted_;
  }
  // Confirms the stop if the newest state follows a command with the request. An earlier state may
  // refer to a previous stop, which may be reset before the request arrives.
  void Take(const SlaveState& newest, bool observed) noexcept {
    shown_ = newest.stops;
    if (observed) return;  // its commands are those of another master
    if (newest.phase == Phase::kEstop && newest.command_sequence >= sequence_) {
      Act(put_, newest.stops);
    }
  }
  // Whether a request is not confirmed, or only by a call: the newest state is older than the stop.
  [[nodiscard]] bool is_pending() const noexcept { return is_wanted() || shown_ < number_; }

 private:
  template <class T>
  static void Raise(std::atomic<T>* value, T least) noexcept {
    T now = *value;
    while (now < least && !value->compare_exchange_weak(now, least)) {
    }
  }

  std::atomic<std::uint32_t> asked_{0}, acted_{0};
  std::atomic<std::uint64_t> number_{0};  // of the newest confirmed stop
  std::uint64_t shown_ = 0;               // of the newest stop in the newest state
  std::uint32_t put_ = 0;                 // put into commands
  std::uint64_t sequence_ = 0;            // of the first command of the last one
};

class StopPath {
 public:
  struct Ways {
    std::function<bool()> asked;  // polled every few milliseconds; may be empty
    // Calls the slave's Stop and returns the number of the stop; 0: it did not answer. May block;
    // may be empty.
    std::function<std::uint64_t()> call;
    std::function<void()> give_up = {};  // cancels a running `call`
  };
  // `stops` must outlive this object.
  StopPath(StopRequests& stops, Ways ways);
  // Gives a requested stop up to one second to complete.
  ~StopPath();
  StopPath(const StopPath&) = delete;
  StopPath& operator=(const StopPath&) = delete;

 private:
  StopRequests& stops_;
  std::function<void()> give_up_;
  std::atomic<bool> calls_{false};  // the calling thread runs
  std::jthread watching_, calling_;
};

}  // namespace palpate
