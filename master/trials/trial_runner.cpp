#include "master/trials/trial_runner.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kRetryEvery = 0.5, kActiveWithin = 20;  // [s]
constexpr double kRounding = 1e-6;                       // of scales on the wire [-]
constexpr auto kPoll = std::chrono::milliseconds(5);

bool IsSame(const std::optional<double>& wanted, double present) {
  return !wanted || std::abs(present - *wanted) <= kRounding * *wanted;
}

}  // namespace

TrialRunner::TrialRunner(std::vector<Trial> trials, OperatorRequests* requests, Slave slave)
    : trials_(std::move(trials)), requests_(requests), slave_(std::move(slave)) {
  requests_->trial = &trials_.front().label;
  requests_->between_trials = true;
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void TrialRunner::See(const TickRecord& tick) {
  engaged_ = tick.state == OperatorState::kAligning || tick.state == OperatorState::kFollowing ||
             tick.state == OperatorState::kHold;
  position_scale_ = tick.position_scale;
  force_scale_ = tick.force_scale;
  render_ = tick.render;
  reads_settings_ =
      tick.state == OperatorState::kDisconnected || tick.chain.reasons.Has(Reason::kSettings);
}

std::vector<std::string> TrialRunner::TakeNotices() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(notices_, {});
}

std::string TrialRunner::failure() const {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

void TrialRunner::Notify(const std::string& notice) {
  const std::scoped_lock lock(mutex_);
  notices_.push_back(notice);
}

bool TrialRunner::WaitFor(const std::function<bool()>& met, double seconds,
                          const std::stop_token& stop) {
  const Time end = Clock::now() + Seconds(seconds);
  while (!stop.stop_requested() && Clock::now() < end) {
    if (met()) return true;
    std::this_thread::sleep_for(kPoll);
  }
  return false;
}

void TrialRunner::Run(const std::stop_token& stop) {
  const auto never = [] { return false; };
  for (const Trial& trial : trials_) {
    if (!Prepare(trial, stop)) break;
    const std::string name =
        Formatted("trial %u of %zu: ", trial.label.number, trials_.size()) + trial.condition.label;
    Notify(name + Formatted(", %g s", trial.condition.seconds));
    WaitFor(never, trial.condition.seconds, stop);
    if (stop.stop_requested()) break;
    Notify(name + " is over: retract the tool and open the switch");
  }
  over_ = true;
}

bool TrialRunner::Prepare(const Trial& trial, const std::stop_token& stop) {
  constexpr double kAnyTime = 1e9;  // [s]
  std::string told;
  while (WaitFor([this] { return !engaged_ && !reads_settings_; }, kAnyTime, stop)) {
    requests_->between_trials = true;
    const std::string reason = Apply(trial.condition);
    if (reason.empty()) {
      requests_->trial = &trial.label;
      const bool is_active =
          WaitFor([&] { return IsActive(trial.condition); }, kActiveWithin, stop);
      requests_->between_trials = false;
      if (!is_active && !stop.stop_requested()) {
        const std::scoped_lock lock(mutex_);
        failure_ = "the settings of trial " + trial.condition.label + " did not become active";
      }
      return is_active;
    }
    if (reason.find("accepted is") != std::string::npos) {  // a value that no wait changes
      const std::scoped_lock lock(mutex_);
      failure_ = "trial " + trial.condition.label + ": " + reason;
      return false;
    }
    requests_->between_trials = false;
    if (std::exchange(told, reason) != reason) {
      Notify("trial " + trial.condition.label + " waits: " + reason);
    }
    WaitFor([] { return false; }, kRetryEvery, stop);
  }
  return false;
}

std::string TrialRunner::Apply(const TrialCondition& condition) {
  if (condition.render) requests_->render = *condition.render;
  if (condition.model_kind && *condition.model_kind != model_) {
    const std::string reason = slave_.set_model(*condition.model_kind);
    if (!reason.empty()) return reason;
    model_ = *condition.model_kind;
  }
  const SlaveLink::Mapping mapping{
      condition.position_scale, condition.force_scale, {}, condition.young_modulus};
  const bool has_any = mapping.position_scale || mapping.force_scale || mapping.young_modulus;
  return has_any ? slave_.set_mapping(mapping) : std::string();
}

bool TrialRunner::IsActive(const TrialCondition& condition) const {
  return !reads_settings_ && IsSame(condition.position_scale, position_scale_) &&
         IsSame(condition.force_scale, force_scale_) &&
         (!condition.render || render_ == *condition.render);
}

}  // namespace palpate
