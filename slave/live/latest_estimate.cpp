#include "slave/live/latest_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <spdlog/spdlog.h>

#include "shared/validation/validation.h"

namespace palpate {
namespace {

constexpr double kStaleAfter = 0.060;  // [s]
constexpr double kStalePeriods = 3;
constexpr std::size_t kTracesKept = 256;

std::string Silence(double age) {
  return "no sample from the sensor for " +
         (age < 1 ? std::string("a moment") : std::to_string(std::lround(age)) + " s") +
         ": check its driver and cable";
}

}  // namespace

LatestEstimate::LatestEstimate(double sensor_rate, const Eigen::Vector3d& p_S_tip)
    : stale_after_(std::max(kStaleAfter, kStalePeriods / sensor_rate)) {
  estimate_.p_S_tip = p_S_tip;
}

void LatestEstimate::Put(const ContactEstimate& estimate, SampleTrace trace) {
  Validate(estimate, "LatestEstimate::Put");
  trace.sample = estimate.sample;
  trace.sensed_at = estimate.sensed_at;
  trace.solved_at = Clock::now();
  {
    const std::lock_guard lock(mutex_);
    traces_.push_back(trace);
    if (traces_.size() > kTracesKept) traces_.pop_front();
    estimate_ = estimate;
    events_.Add(estimate.events);
    ++frames_;
    std::erase_if(recent_, [&](Time t) { return SecondsBetween(t, estimate.sensed_at) > 1.0; });
    recent_.push_back(estimate.sensed_at);
  }
  changed_.notify_all();
}

void LatestEstimate::Add(Event event) {
  const std::lock_guard lock(mutex_);
  events_.Add(event);
}

void LatestEstimate::RaiseAlarm(std::string_view kind, const std::string& text) {
  spdlog::warn("{}", text);
  const std::lock_guard lock(mutex_);
  auto alarm = std::ranges::find(alarms_, kind, &Alarm::kind);
  if (alarm == alarms_.end()) alarm = alarms_.insert(alarm, Alarm{kind, {}, 0});
  alarm->newest = text;
  ++alarm->count;
}

ContactEstimate LatestEstimate::Get() const {
  const std::lock_guard lock(mutex_);
  return estimate_;
}

ContactEstimate LatestEstimate::Fresh(Time now) const {
  ContactEstimate estimate = Get();
  if (SecondsBetween(estimate.sensed_at, now) <= stale_after_ + idle_wait_) return estimate;
  estimate.validity = Worse(estimate.validity, Validity::kStale);
  for (FingerState& finger : estimate.fingers) {
    finger.validity = Worse(finger.validity, Validity::kStale);
  }
  return estimate;
}

bool LatestEstimate::Touches() const {
  const ContactEstimate estimate = Get();
  const auto touches = [](const FingerState& finger) { return finger.in_contact; };
  return estimate.depth > 0 || estimate.local_model.in_contact ||
         std::ranges::any_of(estimate.fingers, touches);
}

bool LatestEstimate::TouchesAsFarAsKnown() const {
  constexpr std::array kRestUnknown{FailedCheck::kRegistration, FailedCheck::kCameraMotion,
                                    FailedCheck::kRestShape, FailedCheck::kRestDrift};
  const ContactEstimate estimate = Get();
  if (estimate.validity == Validity::kTrackingLost) return false;
  return std::ranges::find(kRestUnknown, estimate.check) == kRestUnknown.end() && Touches();
}

std::vector<SampleTrace> LatestEstimate::TracesSince(Time sensed_at) const {
  const std::lock_guard lock(mutex_);
  const auto first = std::ranges::find_if(
      traces_, [&](const SampleTrace& trace) { return trace.sensed_at > sensed_at; });
  return {first, traces_.end()};
}

Events LatestEstimate::TakeEvents() {
  const std::lock_guard lock(mutex_);
  const Events events = events_;
  events_.Clear();
  return events;
}

bool LatestEstimate::WaitForNewer(Time sensed_at, std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, std::chrono::steady_clock::now() + timeout,
                             [&] { return estimate_.sensed_at > sensed_at; });
}

SlaveState LatestEstimate::Compose(const OperatorPort& port, Time now) const {
  SlaveState state;
  static_cast<ContactEstimate&>(state) = Fresh(now);
  static_cast<OperatorView&>(state) = port.view();
  state.events.Clear();
  // A sample or a command may have been taken since `now`.
  state.sent_at = std::max(now, state.sensed_at);
  state.echo_delay = state.echo ? std::max(0.0, SecondsBetween(state.taken_at, now)) : 0;
  Validate(state, "LatestEstimate::Compose");
  return state;
}

void LatestEstimate::Describe(SlaveStatus* status) const {
  const Time now = Clock::now();
  status->validity = Fresh(now).validity;
  const std::lock_guard lock(mutex_);
  status->frames = frames_;
  status->frame_rate = static_cast<double>(
      std::ranges::count_if(recent_, [&](Time t) { return SecondsBetween(t, now) <= 1.0; }));
  for (const Alarm& alarm : alarms_) {
    const std::string count =
        alarm.count == 1 ? "" : " (raised " + std::to_string(alarm.count) + " times)";
    status->alarms.push_back(alarm.newest + count);
  }
  const double age = SecondsBetween(estimate_.sensed_at, now);
  if (frames_ > 0 && age > stale_after_ + idle_wait_) status->alarms.push_back(Silence(age));
}

}  // namespace palpate
