// How calls and streams end: a status code and a sentence of the slave.
#pragma once

#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>

#include <grpcpp/support/status.h>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/program/progress.h"

namespace palpate {

// How every stream ends when the slave stops.
inline grpc::Status Stopping() {
  return {grpc::StatusCode::UNAVAILABLE, "the slave is stopping"};
}

// Runs `work`. std::invalid_argument: INVALID_ARGUMENT; another std::logic_error (not now):
// FAILED_PRECONDITION; Interrupted: CANCELLED; anything else: INTERNAL.
template <class Work>
grpc::Status Guarded(const Work& work) {
  try {
    work();
    return grpc::Status::OK;
  } catch (const std::invalid_argument& error) {
    return {grpc::StatusCode::INVALID_ARGUMENT, error.what()};
  } catch (const std::logic_error& error) {
    return {grpc::StatusCode::FAILED_PRECONDITION, error.what()};
  } catch (const Interrupted& error) {
    return {grpc::StatusCode::CANCELLED, error.what()};
  } catch (const std::exception& error) {
    return {grpc::StatusCode::INTERNAL, error.what()};
  }
}

// A stream that ends before it began.
template <class Reactor>
class RefusedStream final : public Reactor {
 public:
  explicit RefusedStream(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

// A stream as a reactor, because it must end with our status while a read is pending, which a
// blocking handler cannot. It owns itself from its opening until gRPC is done with it. gRPC is
// never called with the mutex held (callbacks may run inside), and Finish waits until no thread is
// busy.
template <class Reactor>
class EndingStream : public Reactor {
 public:
  void OnCancel() override { End(grpc::Status::CANCELLED); }
  void OnDone() override { const auto last = std::move(self_); }  // others may hold a different one

 protected:
  // Ends the stream with `status` as soon as that is possible. The first status counts.
  void End(const grpc::Status& status) {
    OnEnding();
    {
      const std::scoped_lock lock(mutex_);
      if (!ending_) ending_ = status;
    }
    FinishIfQuiet();
  }
  // A thread begins to start a read or to process one; false: the stream is ending.
  bool Enter() {
    const std::scoped_lock lock(mutex_);
    if (!ending_) ++busy_;
    return !ending_;
  }
  void Exit() {
    {
      const std::scoped_lock lock(mutex_);
      --busy_;
    }
    FinishIfQuiet();
  }

  // Starts the next read into `message`, unless the stream is ending.
  template <class Message>
  void Read(Message* message) {
    if (!Enter()) return;
    this->StartRead(message);
    Exit();
  }

  std::shared_ptr<EndingStream> self_;  // until OnDone
  PriorityInheritanceMutex mutex_;      // guards the members below
  std::optional<grpc::Status> ending_;
  int busy_ = 0;  // threads between Enter and Exit, and writes in flight

 private:
  // Called each time a thread ends the stream.
  virtual void OnEnding() {}
  // Once, before the peer hears that its stream is over.
  virtual void OnQuiet() {}

  void FinishIfQuiet() {
    {
      const std::scoped_lock lock(mutex_);
      if (!ending_ || busy_ > 0 || finished_) return;
      finished_ = true;
    }
    OnQuiet();
    this->Finish(*ending_);  // constant from then on
  }

  bool finished_ = false;  // guarded too
};

}  // namespace palpate
