// The one thread that composes states and gives them to whoever reads: the operator first, then the
// observers. Each reader has a slot of its own, so that a slow one loses old states and slows
// nobody.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

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
  void Publish();

  Slave& slave_;
  std::uint64_t sequence_ = 0;  // the thread's own, as are readers_ and sensed_at_
  std::vector<std::shared_ptr<StateReader>> readers_;
  Time sensed_at_{};

  std::mutex mutex_;  // guards what follows
  std::weak_ptr<StateReader> operator_;
  std::vector<std::weak_ptr<StateReader>> observers_;
  Events flagged_;
  bool stopped_ = false;

  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
