#include "slave/live/live_slave.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/state/driven_clock.h"
#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

// Returns whether the samples show the manipulator's present tool, unlike recorded samples.
bool ShowsTool(SensingPipeline& sense, const Manipulator& manipulator) {
  const bool is_observed = sense.health().has_value() || sense.inbox() != nullptr;
  return manipulator.carries_tool() && (is_observed || manipulator.comes_with_samples());
}

// A pipeline that estimates no force does not report that the force is unknown for too long.
ManipulatorOptions LimitsOf(const Scene& scene, const SensingPipeline& sense) {
  ManipulatorOptions limits = scene.manipulator;
  if (!sense.info().has_force_estimate)
    limits.blind_after = std::numeric_limits<double>::infinity();
  return limits;
}

}  // namespace

LiveSlave::LiveSlave(const Scene& scene, std::unique_ptr<Manipulator> manipulator,
                     std::unique_ptr<SensingPipeline> sense)
    : has_scene_(!scene.name.empty()),
      manipulator_(std::move(manipulator)),
      sense_(std::move(sense)),
      port_(*manipulator_, scene.operator_options.transform, LimitsOf(scene, *sense_),
            scene.link.dead_after),
      newest_(SensorRate(scene.sense), scene.manipulator.home),
      settings_(scene, sense_.get(), &sense_mutex_, &port_, &newest_),
      sensing_(scene, {*sense_, sense_mutex_, settings_, *manipulator_, port_, newest_},
               ShowsTool(*sense_, *manipulator_)),
      watchdog_(port_, [this] { return ContactStateNow(); }) {
  if (DrivenClock::is_active()) return;
  sensing_.Begin();
  watchdog_.Start();
  sensing_.Start();
}

// The sensing thread ends first, because it calls the other parts and they use its results.
LiveSlave::~LiveSlave() {
  sensing_.Stop();
}

bool LiveSlave::Step(const std::stop_token& stop) {
  if (!Acquire(stop)) return false;
  Estimate();
  return true;
}

ContactEstimate LiveSlave::Estimate() {
  sensing_.Estimate();
  Watch();
  return newest_.Get();
}

bool LiveSlave::Command(const OperatorCommand& command) noexcept {
  OperatorCommand accepted = command;
  // An operator with old settings would move the tool to a wrong position.
  const std::uint32_t known = command.settings_revision;
  if (known != 0 && known != settings_.revision()) accepted.engaged = false;
  return port_.Command(accepted, Clock::now());
}

ContactState LiveSlave::ContactStateNow() const {
  const ContactEstimate estimate = newest_.Fresh(Clock::now());
  ContactState contact;
  if (IsForceKnown(estimate)) contact.force = estimate.force;
  contact.depth = estimate.depth;
  if (estimate.local_model.known()) contact.outward = estimate.local_model.normal;
  if (estimate.force && estimate.force->norm() > 0) contact.outward = estimate.force->normalized();
  sensing_.local().AddTo(&contact, manipulator_->Tip(), estimate.validity == Validity::kPunctured);
  return contact;
}

SlaveState LiveSlave::Compose(Time now) {
  SlaveState state = newest_.Compose(port_, now);
  state.phase = Shown(state.phase);
  state.settings_revision = settings_.revision();
  state.true_force = manipulator_->measured_force();
  if (manipulator_->is_faulty()) {
    state.Add({state.validity, FailedCheck::kArmFault, "the manipulator has a fault"});
  }
  state.local_model = sensing_.LocalNow();
  return state;
}

Events LiveSlave::TakeEvents() {
  Events events = port_.TakeEvents();
  events.Add(newest_.TakeEvents());
  return events;
}

SlaveDescription LiveSlave::Describe() const {
  SlaveDescription description;
  // Read before the settings, so that it is never newer than they are.
  description.settings_revision = settings_.revision();
  description.scene = settings_.scene();
  description.sense = settings_.info();
  description.scene.operator_options.transform = port_.transform();
  description.simulated = description.scene.is_simulated;
  description.turns = manipulator_->Rotation().has_value();
  description.setup_camera = setup_camera_;
  return description;
}

SlaveStatus LiveSlave::Status() const {
  SlaveStatus status;
  status.stops = port_.stops();  // before the phase: it may be too old for a reset, never too new
  status.phase = Shown(port_.view().phase);
  const CommandCounts counts = port_.counts();
  status.commands = counts.taken;
  status.commands_refused = counts.refused;
  status.started_at = started_at_;
  status.stages = sensing_.Stages();
  newest_.Describe(&status);
  status.arm = manipulator_->health();
  status.cameras = sense_->health();
  if (std::string words = stop_record_.Words(); !words.empty()) status.alarms.push_back(words);
  const std::string trouble = recorder_ == nullptr ? "" : recorder_->trouble();
  if (!trouble.empty()) status.alarms.push_back(trouble);
  if (status.arm && !status.arm->fault.empty()) status.alarms.push_back(status.arm->fault);
  if (status.cameras && !status.cameras->trouble.empty())
    status.alarms.push_back(status.cameras->trouble);
  return status;
}

void LiveSlave::OfferSetup(SceneSetup* setup, std::string camera) {
  setup_ = setup;
  setup_camera_ = std::move(camera);
}

void LiveSlave::Reset(std::uint64_t stops) {
  if (port_.view().phase != Phase::kEstop) return ReinitializeTracking();
  stop_control_.Reset(stops);
}

void LiveSlave::ReinitializeTracking() {
  settings_.RefuseUnlessFree();
  sensing_.RequestReset();
}

void LiveSlave::RecordStop(const std::string& reason) {
  const std::string trouble = stop_control_.Record(reason);
  if (!trouble.empty()) newest_.RaiseAlarm("stop record", trouble);
}

void LiveSlave::KeepStopIn(const std::filesystem::path& folder) {
  if (stop_record_.KeepIn(folder)) port_.EmergencyStop();
}

BoundaryShape LiveSlave::Shape(const ShapeParts& parts) {
  const std::lock_guard lock(sense_mutex_);
  return sense_->Shape(parts);
}

std::optional<EncodedImage> LiveSlave::Image(bool overlays, int quality) {
  const double full_scale = settings_.FullScale();
  std::optional<OverlaidImage> seen;
  {
    const std::lock_guard lock(sense_mutex_);
    seen = sense_->Image(full_scale);
  }
  if (!seen) return std::nullopt;
  return EncodedImage{seen->sensed_at, EncodeJpeg(overlays ? seen->draw() : seen->plain, quality),
                      seen->plain.cols, seen->plain.rows};
}

}  // namespace palpate
