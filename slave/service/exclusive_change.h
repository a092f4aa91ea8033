// Runs slow changes of settings one after the other.
#pragma once

#include <functional>
#include <mutex>

#include <grpcpp/server_context.h>

#include "slave/program/progress.h"

namespace palpate {

// Only one change runs at a time, and none waits. A change ends with the call that requested it.
// Thread-safe.
class ExclusiveChange {
 public:
  // Runs `work(progress)` for the call of `context`; ABORTED: another change is running. Exceptions
  // of `work`: as in Guarded.
  grpc::Status Run(const grpc::ServerContext& context, const std::function<void(Progress*)>& work);

 private:
  std::mutex one_at_a_time_;
};

}  // namespace palpate
