// The thread that composes states and passes them to readers: the operator first, then the
// observers. Each reader has its own slot, so a slow reader loses old states and delays no other.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <grpcpp/support/status.h>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/live/slave.h"
#include "slave/service/state_mailbox.h"

namespace palpate {

// A reader of all states. Must not block.
class StateReader {
 public:
  virtual ~StateReader() = default;
  virtual void Offer(const SlaveState& state) = 0;
  // No more states: the slave is stopping.
  virtual void Close() = 0;
};

class Publisher {
 public:
  // Lowest rate of states [Hz], also without new samples.
  static constexpr double kStateRate = 200;

  // `slave` outlives the publisher.
  explicit Publisher(Slave& slave) : slave_(slave) {}
  ~Publisher();

  // The mailbox of a new observer; releasing it ends the subscription.
  std::shared_ptr<StateMailbox> Subscribe();
  // From now on `reader` is served first, in place of the previous operator. Releasing it ends the
  // subscription.
  void ServeFirst(const std::shared_ptr<StateReader>& reader);
  // Adds `event` to the next state of every reader.
  void Flag(Event event);

  // Publishes on a separate thread from now on.
  void Start();
  // Composes a state as of `now` and passes it to every reader; false: there is none. The thread
  // calls it.
  bool Publish(Time now);
  // Closes all present and future readers, and joins the thread. Idempotent.
  void Stop();

 private:
  void Run(const std::stop_token& stop);
  // The remaining readers, the operator first; false: none.
  bool CollectReaders();
  // Sleeps, and lets the slave idle, until there is a reader.
  void AwaitReaders(const std::stop_token& stop);

  Slave& slave_;
  std::uint64_t sequence_ = 0;  // used by Publish only, as are readers_ and sensed_at_
  std::vector<std::shared_ptr<StateReader>> readers_;
  Time sensed_at_{};

  PriorityInheritanceMutex mutex_;  // guards the members below
  PriorityInheritanceCondition joined_;
  std::weak_ptr<StateReader> operator_;
  std::vector<std::weak_ptr<StateReader>> observers_;
  Events flagged_;
  bool stopped_ = false;

  std::jthread thread_;  // last: it uses all of the above
};

// Limits the number of streams that each use a thread. Privileged streams have a few additional
// seats.
class Seats {
 public:
  explicit Seats(int count, int privileged = 0) : count_(count), privileged_(privileged) {}

  // A seat that is released at the end of its scope. Empty if all are in use.
  class Seat {
   public:
    explicit Seat(Seats* seats, bool is_privileged = false) : seats_(seats) {
      seated_ = seats->taken_++ < seats->count_ + (is_privileged ? seats->privileged_ : 0);
    }
    ~Seat() { --seats_->taken_; }
    Seat(const Seat&) = delete;
    Seat& operator=(const Seat&) = delete;
    explicit operator bool() const { return seated_; }

   private:
    Seats* seats_;
    bool seated_;
  };

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] int taken() const { return std::min(taken_.load(), count_ + privileged_); }

 private:
  const int count_, privileged_;
  std::atomic<int> taken_{0};
};

}  // namespace palpate
