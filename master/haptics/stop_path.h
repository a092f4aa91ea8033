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
  // Confirms the first `stops` requests, after the slave has stopped.
  void Act(std::uint32_t stops) noexcept {
    std::uint32_t acted = acted_;
    while (acted < stops && !acted_.compare_exchange_weak(acted, stops)) {
    }
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
  void Take(const SlaveState& newest) noexcept {
    if (newest.phase == Phase::kEstop && newest.command_sequence >= sequence_) Act(put_);
  }

 private:
  std::atomic<std::uint32_t> asked_{0}, acted_{0};
  std::uint32_t put_ = 0;       // put into commands
  std::uint64_t sequence_ = 0;  // of the first command of the last one
};

class StopPath {
 public:
  struct Ways {
    std::function<bool()> asked;  // polled every few milliseconds; may be empty
    std::function<bool()>
        call;  // calls the slave's Stop; true: it stopped. May block; may be empty
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
