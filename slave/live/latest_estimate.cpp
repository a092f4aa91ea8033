#include "slave/live/latest_estimate.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <spdlog/spdlog.h>

namespace palpate {
namespace {

constexpr double kStaleAfter = 0.060;  // [s]
constexpr double kStalePeriods = 3;
constexpr std::size_t kMaxAlarms = 16;
constexpr std::size_t kTracesKept = 256;

std::string Silence(double age) {
  return "no sample from the sensor for " +
         (age < 1 ? std::string("a moment") : std::to_string(std::lround(age)) + " s") +
         ": check its driver and cable";
}

}  // namespace

LatestEstimate::LatestEstimate(double sensor_rate, const Eigen::Vector3d& p_S_tip)
    : stale_after_(std::max(kStaleAfter, kStalePeriods / sensor_rate)) {
  felt_.p_S_tip = p_S_tip;
}

void LatestEstimate::Put(const ContactEstimate& felt, SampleTrace trace) {
  trace.sample = felt.sample;
  trace.sensed_at = felt.sensed_at;
  trace.solved_at = Clock::now();
  {
    const std::lock_guard lock(mutex_);
    traces_.push_back(trace);
    if (traces_.size() > kTracesKept) traces_.pop_front();
    felt_ = felt;
    events_.Add(felt.events);
    ++frames_;
    std::erase_if(recent_, [&](Time t) { return SecondsBetween(t, felt.sensed_at) > 1.0; });
    recent_.push_back(felt.sensed_at);
  }
  changed_.notify_all();
}

void LatestEstimate::Add(Event event) {
  const std::lock_guard lock(mutex_);
  events_.Add(event);
}

void LatestEstimate::RaiseAlarm(const std::string& text) {
  spdlog::warn("{}", text);
  const std::lock_guard lock(mutex_);
  const bool is_known = std::ranges::find(alarms_, text) != alarms_.end();
  if (!is_known && alarms_.size() < kMaxAlarms) alarms_.push_back(text);
}

ContactEstimate LatestEstimate::Get() const {
  const std::lock_guard lock(mutex_);
  return felt_;
}

ContactEstimate LatestEstimate::Fresh(Time now) const {
  ContactEstimate felt = Get();
  if (SecondsBetween(felt.sensed_at, now) <= stale_after_ + nap_) return felt;
  felt.validity = Worse(felt.validity, Validity::kStale);
  for (FingerState& finger : felt.fingers) {
    finger.validity = Worse(finger.validity, Validity::kStale);
  }
  return felt;
}

bool LatestEstimate::Touches() const {
  const ContactEstimate felt = Get();
  const auto touches = [](const FingerState& finger) { return finger.in_contact; };
  return felt.depth > 0 || felt.local_model.in_contact ||
         std::ranges::any_of(felt.fingers, touches);
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

bool LatestEstimate::WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, std::chrono::steady_clock::now() + patience,
                             [&] { return felt_.sensed_at > sensed_at; });
}

SlaveState LatestEstimate::Compose(const OperatorPort& port, Time now) const {
  SlaveState state;
  static_cast<ContactEstimate&>(state) = Fresh(now);
  static_cast<OperatorView&>(state) = port.view();
  state.events.Clear();
  state.sent_at = now;
  // A command may have been taken since `now`.
  state.echo_delay = state.echo ? std::max(0.0, SecondsBetween(state.taken_at, now)) : 0;
  return state;
}

void LatestEstimate::Describe(SlaveStatus* status) const {
  const Time now = Clock::now();
  status->validity = Fresh(now).validity;
  const std::lock_guard lock(mutex_);
  status->frames = frames_;
  status->frame_rate = static_cast<double>(
      std::ranges::count_if(recent_, [&](Time t) { return SecondsBetween(t, now) <= 1.0; }));
  status->alarms = alarms_;
  const double age = SecondsBetween(felt_.sensed_at, now);
  if (frames_ > 0 && age > stale_after_ + nap_) status->alarms.push_back(Silence(age));
}

}  // namespace palpate
