#include "slave/live/live_sensing.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/thread_priority.h"
#include "shared/state/driven_clock.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kFirstSampleWait(50);  // after a client began to watch
constexpr std::chrono::seconds kRetryAfter(1);             // after a sample that broke the sensing

}  // namespace

LiveSensing::LiveSensing(const Scene& scene, const Parts& parts, bool shows_tool)
    : parts_(parts),
      shows_tool_(shows_tool),
      planned_depth_(scene.operator_options.press_depth),
      p_S_sensed_(parts.manipulator.Tip()),
      p_S_encoders_(p_S_sensed_),
      patch_({.depth = scene.operator_options.press_depth, .period = 1 / SensorRate(scene.sense)}) {
  BeginRegistration();
}

void LiveSensing::BeginRegistration() {
  registration_.reset();
  // A tip that moves less than the resolution counts as stationary.
  const double resolution = parts_.settings.sensing_info().tip_resolution;
  if (resolution > 0 && parts_.manipulator.carries_tool()) registration_.emplace(resolution);
}

// A manipulator with a fault, or without a driver, reports no position of the tool.
TipReading LiveSensing::ReadEncoders(Time t) const {
  const Manipulator& manipulator = parts_.manipulator;
  TipReading reading{manipulator.TipAt(t), std::nullopt};
  if (shows_tool_ && !manipulator.is_faulty()) reading.frame = manipulator.frame();
  return reading;
}

void LiveSensing::Register(const ContactEstimate& estimate, const Eigen::Vector3d& p_S_encoders) {
  if (!registration_ || estimate.validity != Validity::kValid) return;
  registration_->Add(estimate.p_S_tip, p_S_encoders);
  parts_.port.SetRegistration(registration_->offset());
}

void LiveSensing::Stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  parts_.newest.Wake();
  thread_.join();
}

void LiveSensing::Begin() {
  // Streams begin with the first fed sample.
  const bool is_fed = parts_.sense.inbox() != nullptr || parts_.sense.image_inbox() != nullptr;
  if (!is_fed && !Step({})) {
    const SenseInfo& info = parts_.settings.sensing_info();
    throw std::runtime_error(fmt::format("{}: no {} received", info.source, info.samples));
  }
  stages_ = parts_.sense.Stages();
}

void LiveSensing::Start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void LiveSensing::RequestReset() {
  reset_wanted_ = true;
  throttle_.Wake();
}

void LiveSensing::Run(const std::stop_token& stop) {
  MakeThreadRealtime(kSensingPriority);
  const auto report = [this](double wait) { parts_.newest.SetIdleWait(wait); };
  bool is_new = parts_.settings.sensing_info().is_awaited;
  while (!stop.stop_requested()) {
    try {
      while (Step(stop)) {
        if (std::exchange(is_new, false)) ReportIntroduction();
        throttle_.Wait(stop, report);
      }
      if (stop.stop_requested()) return;
      return parts_.newest.RaiseAlarm(
          "source", parts_.settings.sensing_info().source + ": the source has ended");
    } catch (const std::exception& e) {
      parts_.newest.RaiseAlarm("sensing", e.what());
    }
    // The next sample may be usable. Until then the state is kStale.
    std::mutex none;
    std::unique_lock lock(none);
    std::condition_variable_any().wait_for(lock, stop, kRetryAfter, [] { return false; });
  }
}

void LiveSensing::ReportIntroduction() const {
  for (const std::string& line : Introduction(parts_.settings.sensing_info()))
    spdlog::info("{}", line);
}

void LiveSensing::SetWatched(bool is_watched) {
  const Time now = Clock::now();
  throttle_.SetWatched(is_watched);
  if (!is_watched || !throttle_.is_allowed()) return;
  parts_.newest.WaitForNewer(now, kFirstSampleWait);
  parts_.newest.SetIdleWait(0);  // The thread does not do it if the sensor has failed.
}

bool LiveSensing::Step(const std::stop_token& stop) {
  if (!Acquire(stop)) return false;
  Estimate();
  return true;
}

bool LiveSensing::Acquire(const std::stop_token& stop) {
  if (!parts_.sense.Acquire(stop)) return false;
  DrivenClock::Reach(parts_.sense.sensed_at());
  trace_ = {.acquired_at = Clock::now()};
  if (parts_.settings.sensing_info().is_awaited) {
    parts_.settings.ReadInfo();
    BeginRegistration();
  }
  return true;
}

void LiveSensing::Estimate() {
  const TipReading encoders = ReadEncoders(parts_.sense.sensed_at());
  if (reset_wanted_.exchange(false)) {
    const std::lock_guard lock(parts_.mutex);
    parts_.sense.Reset([&port = parts_.port] { return port.view().phase != Phase::kFollowing; });
  }
  parts_.sense.Process();
  trace_.processed_at = Clock::now();
  const std::lock_guard lock(parts_.mutex);
  const ContactEstimate estimate = parts_.sense.Estimate(encoders);
  const bool senses_tip = parts_.settings.sensing_info().tip_resolution > 0;
  if (estimate.validity != Validity::kTrackingLost || !senses_tip) {
    p_S_sensed_ = estimate.p_S_tip;
    p_S_encoders_ = encoders.p_S_tip;
  }
  Register(estimate, encoders.p_S_tip);
  ReportExtrapolation();
  patch_.Update(estimate, parts_.settings.revision(), &parts_.sense, Clock::now());
  local_.Put(estimate.local_model, p_S_sensed_, p_S_encoders_);
  has_estimate_ = true;
  // Sensing that processes the sample in the estimate states the time in the estimate.
  trace_.processed_at = std::max(trace_.processed_at, estimate.processed_at);
  parts_.newest.Put(estimate, trace_);
  ReportDepth(estimate);
}

void LiveSensing::ReportExtrapolation() {
  const std::string_view flag_reason = parts_.sense.flag_reason();
  if (!flag_reason.empty() && reported_reasons_.insert(flag_reason).second) {
    parts_.newest.RaiseAlarm(flag_reason,
                             "the model's solution is extrapolated: " + std::string(flag_reason));
  }
}

void LiveSensing::ReportDepth(const ContactEstimate& estimate) {
  const std::string alarm = planned_depth_.Update(estimate, parts_.newest.Touches());
  if (!alarm.empty()) parts_.newest.RaiseAlarm("depth", alarm);
}

// At the sensed tip, moved by the arm's motion since. While a sample is being estimated, the latest
// model is returned.
LocalModel LiveSensing::LocalNow() {
  const std::unique_lock sense(parts_.mutex, std::try_to_lock);
  if (sense.owns_lock() && has_estimate_) {
    const Eigen::Vector3d p_S_arm = parts_.manipulator.Tip();
    const Eigen::Vector3d p_S = p_S_sensed_ + p_S_arm - p_S_encoders_;
    local_.Put(parts_.sense.LocalModelAt(p_S), p_S, p_S_arm);
  }
  return local_.newest();
}

// While a sample is being estimated these are the latest ones, so that a request does not wait.
std::vector<StageTimes> LiveSensing::Stages() const {
  const std::unique_lock sense(parts_.mutex, std::try_to_lock);
  const std::lock_guard lock(stages_mutex_);
  if (sense.owns_lock()) stages_ = parts_.sense.Stages();
  return stages_;
}

}  // namespace palpate
