#include "slave/live/model_validity_monitor.h"

#include <algorithm>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kDeeper = 1.1;    // depth that is a breach, relative to the studied one [-]
constexpr double kReserve = 1.25;  // of depth, so that not every press needs a new decision [-]
constexpr int kWindow = 200;       // updates that are judged together
constexpr int kOneIn = 10;         // share of late updates that is a breach: fewer are accidents
constexpr double kSlower = 2;      // factor of slowness until it is reported again [-]

}  // namespace

ModelValidityMonitor::ModelValidityMonitor(const Scene& scene, Remedy remedy)
    : budget_(1 / scene.model.rate),
      late_from_(budget_),
      studied_(scene.operator_options.press_depth),
      remedy_(std::move(remedy)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void ModelValidityMonitor::Update(const ContactEstimate& estimate, bool touches, double update) {
  if (touches) {
    if (IsForceKnown(estimate)) deepest_ = std::max(deepest_, estimate.depth);
    slow_ += update > late_from_ ? 1 : 0;
    if (++updates_ == kWindow) late_ = slow_, updates_ = slow_ = 0;
    return;
  }
  if (IsBroken()) {
    const bool deeper = deepest_ > kDeeper * studied_;
    const std::string words =
        deeper ? Formatted(
                     "indentation of %.3g mm, but the model chosen by auto was studied to %.3g mm",
                     1e3 * deepest_, 1e3 * studied_)
               : Formatted(
                     "%d of %d updates took longer than %.3g ms, the period of the requested rate",
                     late_, kWindow, 1e3 * budget_);
    if (deeper)
      studied_ = kReserve * deepest_;
    else
      late_from_ *= kSlower;
    updates_ = slow_ = late_ = 0;
    {
      const std::lock_guard lock(mutex_);
      breach_ = {studied_, words};
    }
    changed_.notify_all();
  }
  deepest_ = 0;
}

bool ModelValidityMonitor::IsBroken() const noexcept {
  return deepest_ > kDeeper * studied_ || kOneIn * late_ > kWindow;
}

void ModelValidityMonitor::Run(const std::stop_token& stop) {
  constexpr int kNicest = 19;  // whoever feels or moves goes first
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNicest);
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return breach_.has_value(); })) {
    const Breach breach = *std::exchange(breach_, std::nullopt);
    lock.unlock();
    remedy_(breach, stop);
    lock.lock();
  }
}

}  // namespace palpate
