// The calls of an operator beside the stream: emergency stop, reset, settings. All are thread-safe.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>

#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/slave_link.h"
#include "shared/link/priority_inheritance_mutex.h"

namespace palpate {

// Why `status` rejects a call; empty: it does not.
std::string Refusal(const grpc::Status& status);

void SetDeadline(grpc::ClientContext* context, std::chrono::milliseconds from_now);

class OperatorCalls {
 public:
  static constexpr std::chrono::milliseconds kMinDeadline{1000};

  // A call during its scope, which End cancels.
  class Scope {
   public:
    Scope(OperatorCalls* calls, grpc::ClientContext* context);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    OperatorCalls* calls_;
    grpc::ClientContext* context_;
  };

  // Calls use `stub`, which must outlive this object, from now on. Only while no call is pending.
  void Use(v1::Teleoperation::Stub* stub) { stub_ = stub; }
  // The deadline of a call, unless another one is stated.
  void set_deadline(std::chrono::milliseconds deadline) { deadline_ = deadline; }
  [[nodiscard]] std::chrono::milliseconds deadline() const { return deadline_; }
  // Cancels running and later calls, except EmergencyStop.
  void End();

  // Requests the slave's emergency stop. Returns its number; 0: the slave does not answer.
  std::uint64_t EmergencyStop(const std::string& reason);
  void GiveUpStop();  // cancels a running EmergencyStop
  // Resets the emergency stop number `stops`: that of the newest state when the operator decided,
  // so that no later stop is cleared. Returns the reason if it is not reset, else an empty string.
  std::string Reset(std::uint64_t stops);
  // Cancels a running Reset, because a stop was requested.
  void CancelReset();
  // Requests new tip, template and baseline. An emergency stop stays active. Returns the reason if
  // the slave rejects it, else an empty string.
  std::string ReinitializeTracking();
  // Change scales and limit, or the model, of the slave while the operator is disengaged. Absent
  // values stay. Return the slave's reason on rejection, else an empty string. A model takes at
  // most 15 s.
  std::string SetMapping(const SlaveLink::Mapping& mapping);
  std::string SetModel(const std::string& kind);

 private:
  // Sets `*place` to `call` while it runs, so that another thread can cancel it; null: no call.
  void Announce(grpc::ClientContext* call, grpc::ClientContext** place);
  void Cancel(grpc::ClientContext* const* place);

  v1::Teleoperation::Stub* stub_ = nullptr;
  std::atomic<std::chrono::milliseconds> deadline_{kMinDeadline};
  PriorityInheritanceMutex mutex_;  // guards the members below
  std::set<grpc::ClientContext*> running_;
  bool is_over_ = false;
  grpc::ClientContext *stop_call_ = nullptr, *reset_call_ = nullptr;  // under way
};

}  // namespace palpate
