// A change of settings that takes time.
#pragma once

#include <functional>
#include <mutex>

#include <grpcpp/server_context.h>

#include "slave/program/progress.h"

namespace palpate {

// One at a time, without a queue. It ends with the call that requested it. Thread-safe.
class ChangeUnderWay {
 public:
  // Runs `work(progress)` for the call of `context`; ABORTED: another change is running. Exceptions
  // of `work`: as in Guarded.
  grpc::Status Make(const grpc::ServerContext& context, const std::function<void(Progress*)>& work);

 private:
  std::mutex one_at_a_time_;
};

}  // namespace palpate
