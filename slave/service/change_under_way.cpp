#include "slave/service/change_under_way.h"

#include <chrono>
#include <stop_token>
#include <thread>

#include "shared/link/thread_priority.h"
#include "slave/service/status.h"

namespace palpate {

class ChangeUnderWay::Listener final : public Progress {
 public:
  Listener(ChangeUnderWay& change, const grpc::ServerContext& context)
      : change_(change), context_(context) {
    const std::lock_guard lock(change_.mutex_);
    change_.making_.emplace();
    change_.began_ = Clock::now();
    watcher_ = std::jthread([this](const std::stop_token& end) { Watch(end); });
  }
  ~Listener() override {
    const std::lock_guard lock(change_.mutex_);
    change_.making_.reset();
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void Expect(const PrecomputeCost& cost) override {
    const std::lock_guard lock(change_.mutex_);
    change_.making_->set_expected(change_.making_->expected() + cost.seconds);
  }
  bool Report(std::string_view stage, double done) override {
    const std::lock_guard lock(change_.mutex_);
    change_.making_->set_stage(stage.data(), stage.size());
    change_.making_->set_done(done);
    return !stop_.stop_requested();
  }
  [[nodiscard]] std::stop_token stop() const override { return stop_.get_token(); }

 private:
  // gRPC tells of a cancelled call only when it is asked.
  void Watch(const std::stop_token& end) {
    constexpr std::chrono::milliseconds kLook(20);
    for (; !end.stop_requested(); std::this_thread::sleep_for(kLook)) {
      if (context_.IsCancelled()) return static_cast<void>(stop_.request_stop());
    }
  }

  ChangeUnderWay& change_;
  const grpc::ServerContext& context_;
  std::stop_source stop_;
  std::jthread watcher_;
};

grpc::Status ChangeUnderWay::Make(const grpc::ServerContext& context,
                                  const std::function<void(Progress*)>& work) {
  const OrdinaryPriority ordinary;
  const std::unique_lock one(one_at_a_time_, std::try_to_lock);
  if (!one) {
    return Error(v1::ERROR_REASON_CHANGE_UNDER_WAY,
                 "another change of settings is under way: try again");
  }
  Listener listener(*this, context);
  return Guarded([&] { work(&listener); });
}

void ChangeUnderWay::FillStatus(v1::Status* status) const {
  const std::lock_guard lock(mutex_);
  if (!making_) return;
  *status->mutable_making() = *making_;
  status->mutable_making()->set_elapsed(SecondsBetween(began_, Clock::now()));
}

}  // namespace palpate
