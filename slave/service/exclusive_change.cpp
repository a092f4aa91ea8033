#include "slave/service/exclusive_change.h"

#include <chrono>
#include <stop_token>
#include <thread>

#include "shared/link/thread_priority.h"
#include "slave/service/status.h"

namespace palpate {
namespace {

// Stops the work when its call is cancelled.
class StopWithCall final : public Progress {
 public:
  explicit StopWithCall(const grpc::ServerContext& context)
      : context_(context), watcher_([this](const std::stop_token& end) { PollCall(end); }) {}

  bool Report(std::string_view /*stage*/, double /*done*/) override {
    return !stop_.stop_requested();
  }
  [[nodiscard]] std::stop_token stop() const override { return stop_.get_token(); }

 private:
  // gRPC reports a cancelled call only when it is queried.
  void PollCall(const std::stop_token& end) {
    constexpr std::chrono::milliseconds kPeriod(20);
    for (; !end.stop_requested(); std::this_thread::sleep_for(kPeriod)) {
      if (context_.IsCancelled()) return static_cast<void>(stop_.request_stop());
    }
  }

  const grpc::ServerContext& context_;
  std::stop_source stop_;
  std::jthread watcher_;
};

}  // namespace

grpc::Status ExclusiveChange::Run(const grpc::ServerContext& context,
                                  const std::function<void(Progress*)>& work) {
  const std::unique_lock one(one_at_a_time_, std::try_to_lock);
  if (!one) {
    return Error(v1::ERROR_REASON_CHANGE_UNDER_WAY,
                 "another change of settings is under way: try again");
  }
  StopWithCall progress(context);  // its thread uses gRPC
  const OrdinaryPriority ordinary;
  return Guarded([&] { work(&progress); });
}

}  // namespace palpate
