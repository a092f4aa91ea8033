// The one thread that composes states and gives them to whoever reads: the operator first, then the
// observers. Each reader has a slot of its own, so that a slow one loses old states and slows
// nobody.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <grpcpp/support/status.h>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/link/state_mailbox.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Somebody who is offered every state. Must not block.
class StateReader {
 public:
  virtual ~StateReader() = default;
  virtual void Offer(const SlaveState& state) = 0;
  // No more states: the slave is stopping.
  virtual void Close() = 0;
};

class Publisher {
 public:
  // States leave at this rate at least [Hz], whether or not something new was sensed.
  static constexpr double kStateRate = 200;

  // `slave` outlives the publisher.
  explicit Publisher(Slave& slave);
  ~Publisher();

  // A new observer's mailbox; it leaves by letting go of it.
  std::shared_ptr<StateMailbox> Subscribe();
  // From now on `reader` is served first, in place of the operator before. It leaves by going.
  void ServeFirst(const std::shared_ptr<StateReader>& reader);
  // Tells every reader of `event` with the next state.
  void Flag(Event event);

  // Closes every reader, now and to come, and joins the thread. Idempotent.
  void Stop();

 private:
  void Run(const std::stop_token& stop);
  // Whoever still reads, the operator first; false: nobody.
  bool CollectReaders();
  // Sleeps, and lets the slave rest, until somebody reads.
  void AwaitReaders(const std::stop_token& stop);
  void Publish();

  Slave& slave_;
  std::uint64_t sequence_ = 0;  // the thread's own, as are readers_ and sensed_at_
  std::vector<std::shared_ptr<StateReader>> readers_;
  Time sensed_at_{};

  PriorityInheritanceMutex mutex_;  // guards what follows
  std::condition_variable_any joined_;
  std::weak_ptr<StateReader> operator_;
  std::vector<std::weak_ptr<StateReader>> observers_;
  Events flagged_;
  bool stopped_ = false;

  std::jthread thread_;  // last: it uses all of the above
};

// How many may watch at once: each watching stream holds a thread.
class ObserverSeats {
 public:
  static constexpr int kSeats = 64;

  // A seat, given back at the end of its scope. Empty if all were taken.
  class Seat {
   public:
    explicit Seat(ObserverSeats* seats)
        : seats_(seats), seated_(seats->taken_.fetch_add(1) < kSeats) {}
    ~Seat() { --seats_->taken_; }
    Seat(const Seat&) = delete;
    Seat& operator=(const Seat&) = delete;
    explicit operator bool() const { return seated_; }

   private:
    ObserverSeats* seats_;
    bool seated_;
  };

  [[nodiscard]] int taken() const { return std::min(taken_.load(), kSeats); }
  static grpc::Status Full() {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED,
            std::to_string(kSeats) + " streams are already open: the limit is reached"};
  }

 private:
  std::atomic<int> taken_{0};
};

}  // namespace palpate
