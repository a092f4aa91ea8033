// A change of settings that takes time.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string_view>

#include <grpcpp/server_context.h>

#include "palpate/v1/telemetry.pb.h"

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"
#include "slave/program/progress.h"

namespace palpate {

// One at a time, without a queue. GetStatus reports its progress, and it ends with the call that
// requested it. Thread-safe.
class ChangeUnderWay {
 public:
  // Runs `work(progress)` for the call of `context`; ABORTED: another change is running. Exceptions
  // of `work`: as in Guarded.
  grpc::Status Make(const grpc::ServerContext& context, const std::function<void(Progress*)>& work);
  // Fills `making` while there is a change.
  void FillStatus(v1::Status* status) const;

 private:
  class Listener;

  std::mutex one_at_a_time_;
  mutable PriorityInheritanceMutex mutex_;  // guards the members below; never locked long
  std::optional<v1::ModelBuildProgress> making_;
  Time began_{};
};

}  // namespace palpate
