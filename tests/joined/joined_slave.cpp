#include "tests/joined/joined_slave.h"

#include <algorithm>
#include <stdexcept>
#include <thread>

namespace palpate {
namespace {

constexpr double kSensorRate = 60;  // [Hz]
constexpr double kRadius = 0.05;    // of the local model's validity [m]

ManipulatorOptions JoinedLimits() {
  ManipulatorOptions limits;
  limits.max_speed = 10;
  return limits;
}

double ForceAt(const Eigen::Vector3d& p_S) {
  return JoinedSlave::kStiffness * std::max(0.0, -p_S.y());
}

}  // namespace

bool InstantTool::Command(const Eigen::Vector3d& p_S_target) noexcept {
  const std::scoped_lock lock(mutex_);
  p_S_tip_ = p_S_target;
  return true;
}

Eigen::Vector3d InstantTool::Tip() const noexcept {
  const std::scoped_lock lock(mutex_);
  return p_S_tip_;
}

void SlowStopRecord::End() {
  StopRecord::End();
  if (during_end) during_end();
}

JoinedSlave::JoinedSlave(std::function<Time()> clock)
    : clock_(std::move(clock)),
      port_(tool_, TeleopTransform{}, JoinedLimits()),
      newest_(kSensorRate, tool_.Tip()) {
  set_settings_revision(1);
  Sense();
}

void JoinedSlave::Sense(std::optional<double> force) {
  ContactEstimate estimate;
  {
    const std::scoped_lock lock(mutex_);
    estimate.sample = ++sample_;
  }
  estimate.sensed_at = clock_();
  estimate.validity = Validity::kValid;
  estimate.p_S_tip = tool_.Tip();
  estimate.depth = std::max(0.0, -estimate.p_S_tip.y());
  estimate.force = Eigen::Vector3d(0, force.value_or(ForceAt(estimate.p_S_tip)), 0);
  LocalModel& local = estimate.local_model;
  local.normal = {0, 1, 0};
  local.stiffness(1, 1) = kStiffness;
  local.valid_radius = kRadius;
  local.revision = 1;
  local.in_contact = estimate.depth > 0;
  newest_.Put(estimate);
}

ContactState JoinedSlave::ContactNow() const {
  ContactState contact;
  contact.depth = std::max(0.0, -tool_.Tip().y());
  contact.force = Eigen::Vector3d(0, ForceAt(tool_.Tip()), 0);
  contact.outward = {0, 1, 0};
  return contact;
}

void JoinedSlave::Watch() {
  port_.Watch(clock_(), ContactNow());
}

bool JoinedSlave::has_open_stop() const {
  const std::scoped_lock lock(mutex_);
  return stops_ != ended_stops_;
}

JoinedSlave::Scales JoinedSlave::ScalesOf(std::uint32_t revision) const {
  const std::scoped_lock lock(mutex_);
  return scales_.at(revision);
}

std::uint32_t JoinedSlave::revision() const {
  const std::scoped_lock lock(mutex_);
  return scales_.rbegin()->first;
}

void JoinedSlave::StopDuringNextReset() {
  // The call of another client: its record waits for the reset, the stop of the tool does not.
  record_.during_end = [this] {
    record_.during_end = {};
    const std::uint64_t before = port_.stops();
    other_client_ = std::jthread([this] { EmergencyStop("during a reset"); });
    while (port_.stops() == before) std::this_thread::yield();
  };
}

// As in LiveSlave, a command for another settings revision does not move the tool.
bool JoinedSlave::Command(const OperatorCommand& command) noexcept {
  OperatorCommand checked = command;
  if (command.settings_revision != 0 && command.settings_revision != revision()) {
    checked.engaged = false;
  }
  return port_.Command(checked, clock_());
}

SlaveState JoinedSlave::Compose(Time now) {
  SlaveState state = newest_.Compose(port_, now);
  state.settings_revision = revision();
  state.true_force = Eigen::Vector3d(0, ForceAt(tool_.Tip()), 0);
  return state;
}

SlaveDescription JoinedSlave::Describe() const {
  SlaveDescription description = FakeSlave::Describe();
  description.scene.operator_options.transform = port_.transform();
  description.scene.operator_options.transform.offset.setZero();
  description.settings_revision = revision();
  return description;
}

SlaveStatus JoinedSlave::Status() const {
  SlaveStatus status = FakeSlave::Status();
  status.stops = port_.stops();
  status.phase = port_.view().phase;
  return status;
}

void JoinedSlave::SetParameters(const ParameterChange& change, Progress* /*progress*/) {
  const std::scoped_lock lock(mutex_);
  port_.SetScales(change.position_scale, change.force_scale);
  const TeleopTransform transform = port_.transform();
  scales_[scales_.rbegin()->first + 1] = {transform.position_scale, transform.force_scale};
}

void JoinedSlave::Reset(std::uint64_t stops) {
  std::uint64_t before = 0;
  {
    const std::scoped_lock lock(mutex_);
    before = stops_;
  }
  try {
    stop_control_.Reset(stops);
  } catch (const std::logic_error&) {
    if (other_client_.joinable()) other_client_.join();
    throw;
  }
  if (other_client_.joinable()) other_client_.join();
  const std::scoped_lock lock(mutex_);
  ended_stops_ = std::max(ended_stops_, before);
}

void JoinedSlave::StopTool() noexcept {
  {
    const std::scoped_lock lock(mutex_);
    ++stops_;
  }
  port_.EmergencyStop();
}

}  // namespace palpate
