#include "slave/pipeline/teleop/operated_slave.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "shared/link/thread_priority.h"

namespace palpate {

StageTimes TimesOf(const std::string& name, const LatencyHistogram& h) {
  return {name, h.Quantile(0.5), h.Quantile(0.99), h.max()};
}

OperatedSlave::OperatedSlave(const Scene& scene, double sensor_rate)
    : scene_(scene), newest_(sensor_rate, scene_.manipulator.home) {}

OperatedSlave::~OperatedSlave() {
  StopSensing();
}

void OperatedSlave::StartTool(const SimulatedManipulator::OnStep& on_step) {
  manipulator_ = std::make_unique<SimulatedManipulator>(scene_.manipulator, on_step);
  port_ = std::make_unique<OperatorPort>(*manipulator_, scene_.operator_options.transform);
}

void OperatedSlave::SetRunning(const ModelInfo& model, const std::string& reason) {
  const std::lock_guard lock(settings_mutex_);
  model_info_ = model;
  model_reason_ = reason;
}

void OperatedSlave::StartSensing(std::function<bool(const std::stop_token&)> sense) {
  sensing_ = std::jthread([this, sense = std::move(sense)](const std::stop_token& stop) {
    MakeThreadRealtime(kEyesPriority);
    try {
      while (sense(stop)) {
      }
      if (!stop.stop_requested()) {
        newest_.RaiseAlarm(SourceDescription() + ": the source has ended");
      }
    } catch (const std::exception& e) {
      newest_.RaiseAlarm(e.what());
    }
  });
  operator_watch_.emplace(*port_, [this] { return newest_.Force(); });
}

void OperatedSlave::StopSensing() {
  sensing_.request_stop();
  newest_.Wake();
  if (sensing_.joinable()) sensing_.join();
}

void OperatedSlave::BeginOperating() {
  port_->BeginOperating();
}

bool OperatedSlave::Command(const OperatorCommand& command) noexcept {
  return port_->Command(command, Clock::now());
}

void OperatedSlave::EndOperating() {
  port_->EndOperating();
}

SlaveState OperatedSlave::Compose(Time now) {
  SlaveState state = newest_.Compose(*port_, now);
  state.true_force = TrueForce();
  return state;
}

Events OperatedSlave::TakeEvents() {
  Events events = port_->TakeEvents();
  events.Add(newest_.TakeEvents());
  return events;
}

bool OperatedSlave::WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) {
  return newest_.WaitForNewer(sensed_at, patience);
}

SlaveDescription OperatedSlave::Describe() const {
  SlaveDescription description;
  {
    const std::lock_guard lock(settings_mutex_);
    description.scene = scene_;
    description.model_reason = model_reason_;
    description.model = model_info_;
  }
  description.scene.operator_options.transform = port_->transform();
  description.source = SourceDescription();
  description.simulated = is_simulated();
  return description;
}

SlaveStatus OperatedSlave::Status() const {
  SlaveStatus status;
  status.phase = port_->view().phase;
  status.commands = port_->taken();
  status.commands_refused = port_->refused();
  status.started_at = started_at_;
  {
    const std::lock_guard lock(touch_mutex_);
    status.stages = Stages();
  }
  newest_.Describe(&status);
  return status;
}

Scene OperatedSlave::scene() const {
  const std::lock_guard lock(settings_mutex_);
  return scene_;
}

double OperatedSlave::FullScale() const {
  const std::lock_guard lock(settings_mutex_);
  return scene_.operator_options.force_limit / port_->transform().force_scale;
}

void OperatedSlave::Rebuild(const Scene& changed, const std::function<void()>& may_adopt) {
  const ModelInfo info = Replace(changed, may_adopt);
  {
    const std::lock_guard lock(settings_mutex_);
    scene_ = changed;
    model_info_ = info;
  }
  newest_.Add(Event::kModelChanged);
}

void OperatedSlave::SetModel(const ModelChange& change) {
  const std::lock_guard one_at_a_time(change_mutex_);
  RefuseWhileFollowing(*port_);
  Scene changed = scene();
  Apply(change, &changed.model);
  Rebuild(changed, [this] { RefuseWhileFollowing(*port_); });  // somebody may have begun meanwhile
  const std::lock_guard lock(settings_mutex_);
  model_reason_ = "asked for by SetModel";
}

void OperatedSlave::SetParameters(const ParameterChange& change) {
  CheckRanges(change);
  const std::lock_guard one_at_a_time(change_mutex_);
  if (change.position_scale || change.force_scale) {
    port_->SetScales(change.position_scale, change.force_scale);
  }
  if (change.force_limit) {
    const std::lock_guard lock(settings_mutex_);
    scene_.operator_options.force_limit = *change.force_limit;
  }
  if (change.young_modulus) {
    Scene changed = scene();
    changed.object.material.young_modulus = *change.young_modulus;
    Rebuild(changed, [] {});
  }
}

void OperatedSlave::Reset() {
  port_->Reset();
  const std::lock_guard lock(touch_mutex_);
  ResetSenses();
}

void OperatedSlave::EmergencyStop(const std::string& reason) {
  port_->EmergencyStop();
  spdlog::warn("emergency stop: {}", reason.substr(0, 200));
}

}  // namespace palpate
