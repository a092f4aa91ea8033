// Results of calls and streams: a status code and a message of the slave.
#pragma once

#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>

#include <grpcpp/support/status.h>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/wire/errors.h"
#include "slave/program/progress.h"

namespace palpate {

inline constexpr const char* kNewScene = "the slave starts again with a new scene: connect again";

// Returns the status of every stream when the slave stops. `starts_again`: it restarts with another
// scene.
inline grpc::Status Stopping(bool starts_again = false) {
  return starts_again ? Error(v1::ERROR_REASON_NEW_SCENE, kNewScene)
                      : Error(v1::ERROR_REASON_STOPPING, "the slave is stopping");
}

// A call that is rejected for `reason`.
class RejectedCall : public std::logic_error {
 public:
  RejectedCall(v1::ErrorReason reason, const std::string& message)
      : std::logic_error(message), reason_(reason) {}
  [[nodiscard]] v1::ErrorReason reason() const noexcept { return reason_; }

 private:
  v1::ErrorReason reason_;
};

// Runs `work`. Errors: RejectedCall: its reason; std::invalid_argument: INVALID_FIELD; another
// std::logic_error: TOOL_IN_USE; Interrupted: CANCELLED; anything else: INTERNAL.
template <class Work>
grpc::Status Guarded(const Work& work) {
  try {
    work();
    return grpc::Status::OK;
  } catch (const RejectedCall& error) {
    return Error(error.reason(), error.what());
  } catch (const std::invalid_argument& error) {
    return Error(v1::ERROR_REASON_INVALID_FIELD, error.what());
  } catch (const std::logic_error& error) {
    return Error(v1::ERROR_REASON_TOOL_IN_USE, error.what());
  } catch (const Interrupted& error) {
    return Error(v1::ERROR_REASON_CANCELLED, error.what());
  } catch (const std::exception& error) {
    return Error(v1::ERROR_REASON_INTERNAL, error.what());
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
  // Other threads may own the object.
  void OnDone() override { const auto last = std::move(self_); }

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
  // Called once, before the peer is notified that its stream has ended.
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
