#include "slave/pipeline/teleop/live_slave.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/thread_priority.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/site/environment/simulated_environment.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kRoused(50);  // by then a sample has come, or none will soon

// Whether pictures that are taken now show what a real arm moves.
bool ShowsArm(const Scene& scene, const SensingPipeline& sense, const Manipulator& arm) {
  const bool is_live = sense.health().has_value() || TakesPictures(scene.sense);
  return is_live && HasPictures(scene.sense) && arm.carries_tool();
}

// Where no force is told, none is missed.
ManipulatorOptions LimitsOf(const Scene& scene, const SensingPipeline& sense) {
  ManipulatorOptions limits = scene.manipulator;
  if (!sense.info().tells_force) limits.blind_after = std::numeric_limits<double>::infinity();
  return limits;
}

}  // namespace

LiveSlave::LiveSlave(const Scene& scene, std::unique_ptr<SimulatedEnvironment> environment,
                     std::unique_ptr<Manipulator> manipulator,
                     std::unique_ptr<SensingPipeline> sense, const ModelChooser& choose)
    : environment_(std::move(environment)),
      manipulator_(std::move(manipulator)),
      sense_(std::move(sense)),
      arm_(!environment_ && ShowsArm(scene, *sense_, *manipulator_)),
      port_(*manipulator_, scene.operator_options.transform, LimitsOf(scene, *sense_),
            scene.link.dead_after),
      newest_(SensorRate(scene.sense), scene.manipulator.home),
      settings_(scene, sense_.get(), &sense_mutex_, &port_, &newest_),
      p_S_sensed_(manipulator_->Tip()),
      p_S_encoders_(p_S_sensed_),
      patch_({.depth = scene.operator_options.press_depth, .period = 1 / SensorRate(scene.sense)}) {
  arm_.Begin(settings_.sensing_info().tip_resolution, *manipulator_);
  // Streams begin when somebody feeds them.
  const bool is_fed = sense_->inbox() != nullptr || sense_->pictures() != nullptr;
  if (!is_fed && !ProcessSample({})) {
    const SenseInfo& info = settings_.sensing_info();
    throw std::runtime_error(fmt::format("{}: no {} received", info.source, info.samples));
  }
  stages_ = sense_->Stages();
  watchdog_.emplace(port_, [this] { return ContactStateNow(); });
  if (choose && !scene.model.decision.reason.empty()) {
    model_validity_.emplace(scene, [this, choose](const ModelValidityMonitor::Breach& breach,
                                                  const std::stop_token& stop) {
      newest_.RaiseAlarm(breach.words + ": auto chooses the model again");
      const std::string outcome = settings_.RechooseModel(breach.depth, choose, stop);
      if (!stop.stop_requested()) newest_.RaiseAlarm(outcome);
    });
  }
  sensing_ = std::jthread([this](const std::stop_token& stop) { Sensing(stop); });
}

LiveSlave::~LiveSlave() {
  sensing_.request_stop();
  newest_.Wake();
}

void LiveSlave::Sensing(const std::stop_token& stop) {
  MakeThreadRealtime(kSensingPriority);
  try {
    const auto tell = [this](double nap) { newest_.SetNap(nap); };
    while (ProcessSample(stop)) rest_.Wait(stop, tell);
    if (!stop.stop_requested()) {
      newest_.RaiseAlarm(settings_.sensing_info().source + ": the source has ended");
    }
  } catch (const std::exception& e) {
    newest_.RaiseAlarm(e.what());
  }
}

void LiveSlave::SetWatched(bool is_watched) {
  const Time now = Clock::now();
  rest_.SetWatched(is_watched);
  if (!is_watched || !rest_.is_allowed()) return;
  newest_.WaitForNewer(now, kRoused);
  newest_.SetNap(0);  // also where the sensor died meanwhile and nobody comes back to say so
}

bool LiveSlave::ProcessSample(const std::stop_token& stop) {
  if (!sense_->Acquire(stop)) return false;
  SampleTrace trace{.acquired_at = Clock::now()};
  if (settings_.sensing_info().is_awaited) {
    settings_.ReadInfo();
    arm_.Begin(settings_.sensing_info().tip_resolution, *manipulator_);
    for (const std::string& line : Introduction(settings_.sensing_info())) spdlog::info("{}", line);
  }
  const Eigen::Vector3d p_S_encoders = manipulator_->TipAt(sense_->sensed_at());
  if (reset_wanted_.exchange(false)) {
    const std::lock_guard lock(sense_mutex_);
    sense_->Reset();
  }
  sense_->Process();
  trace.processed_at = Clock::now();
  const std::lock_guard lock(sense_mutex_);
  const Time began = Clock::now();
  ContactEstimate felt = sense_->Estimate(p_S_encoders);
  const bool senses_tip = settings_.sensing_info().tip_resolution > 0;
  arm_.Update(p_S_encoders, &felt);
  if (felt.validity != Validity::kTrackingLost || !senses_tip) {
    p_S_sensed_ = felt.p_S_tip;
    p_S_encoders_ = p_S_encoders;
  }
  arm_.Register(felt, p_S_encoders, &port_);
  ReportExtrapolation();
  patch_.Update(felt, settings_.revision(), sense_.get(), Clock::now());
  local_.Put(felt.local_model, p_S_sensed_, p_S_encoders_);
  // Where looking is a part of the estimate, that one knows when it was done.
  trace.processed_at = std::max(trace.processed_at, felt.processed_at);
  const double update = SecondsBetween(std::max(began, felt.processed_at), Clock::now());
  newest_.Put(felt, trace);
  if (model_validity_) model_validity_->Update(felt, newest_.Touches(), update);
  return true;
}

void LiveSlave::ReportExtrapolation() {
  const std::string_view doubt = sense_->doubt();
  if (!doubt.empty() && told_doubts_.insert(doubt).second) {
    newest_.RaiseAlarm("the model's solution is extrapolated: " + std::string(doubt));
  }
}

bool LiveSlave::Command(const OperatorCommand& command) noexcept {
  OperatorCommand heard = command;
  // Whoever goes by other numbers than ours would move the tool otherwise than meant.
  const std::uint32_t known = command.settings_revision;
  if (known != 0 && known != settings_.revision()) heard.engaged = false;
  return port_.Command(heard, Clock::now());
}

ContactState LiveSlave::ContactStateNow() const {
  const ContactEstimate felt = newest_.Fresh(Clock::now());
  ContactState contact;
  if (IsForceKnown(felt)) contact.force = felt.force;
  contact.depth = felt.depth;
  if (felt.local_model.known()) contact.outward = felt.local_model.normal;
  if (felt.force && felt.force->norm() > 0) contact.outward = felt.force->normalized();
  local_.AddTo(&contact, manipulator_->Tip(), felt.validity == Validity::kPunctured);
  return contact;
}

SlaveState LiveSlave::Compose(Time now) {
  SlaveState state = newest_.Compose(port_, now);
  state.settings_revision = settings_.revision();
  state.true_force = TrueForce();
  if (manipulator_->is_faulty()) {
    state.Add({state.validity, FailedCheck::kArmFault, "the manipulator has a fault"});
  }
  state.local_model = LocalNow();
  return state;
}

// The tip as it was sensed, carried on by what the arm has moved since. While a sample is being
// felt, the model of a moment ago will do.
LocalModel LiveSlave::LocalNow() {
  const std::unique_lock sense(sense_mutex_, std::try_to_lock);
  if (sense.owns_lock()) {
    const Eigen::Vector3d p_S_arm = manipulator_->Tip();
    const Eigen::Vector3d p_S = p_S_sensed_ + p_S_arm - p_S_encoders_;
    local_.Put(sense_->LocalModelAt(p_S), p_S, p_S_arm);
  }
  return local_.newest();
}

std::optional<Eigen::Vector3d> LiveSlave::TrueForce() const {
  if (environment_ == nullptr) return manipulator_->measured_force();
  if (!settings_.sensing_info().tells_force) return std::nullopt;
  const Truth truth = environment_->truth();
  return truth.solved ? std::optional(truth.force) : std::nullopt;
}

Events LiveSlave::TakeEvents() {
  Events events = port_.TakeEvents();
  events.Add(newest_.TakeEvents());
  return events;
}

SlaveDescription LiveSlave::Describe() const {
  SlaveDescription description;
  description.settings_revision = settings_.revision();  // before what it tells of
  description.scene = settings_.scene();
  description.sense = settings_.info();
  description.scene.operator_options.transform = port_.transform();
  description.simulated = environment_ != nullptr;
  return description;
}

SlaveStatus LiveSlave::Status() const {
  SlaveStatus status;
  status.phase = port_.view().phase;
  status.commands = port_.taken();
  status.commands_refused = port_.refused();
  status.started_at = started_at_;
  status.stages = StagesNow();
  newest_.Describe(&status);
  status.arm = manipulator_->health();
  status.cameras = sense_->health();
  if (std::string words = stop_record_.Words(); !words.empty()) status.alarms.push_back(words);
  if (status.arm && !status.arm->fault.empty()) status.alarms.push_back(status.arm->fault);
  if (status.cameras && !status.cameras->trouble.empty())
    status.alarms.push_back(status.cameras->trouble);
  return status;
}

// Of a moment ago while a sample is being felt: whoever asks how we are must not wait.
std::vector<StageTimes> LiveSlave::StagesNow() const {
  const std::unique_lock sense(sense_mutex_, std::try_to_lock);
  const std::lock_guard lock(stages_mutex_);
  if (sense.owns_lock()) stages_ = sense_->Stages();
  return stages_;
}

void LiveSlave::Reset() {
  if (port_.view().phase != Phase::kEstop) return ReinitializeTracking();
  stop_record_.End();
  port_.Reset();
}

void LiveSlave::ReinitializeTracking() {
  settings_.RefuseUnlessFree();
  reset_wanted_ = true;
  rest_.Rouse();
}

void LiveSlave::EmergencyStop(const std::string& reason) {
  const bool is_news = port_.view().phase != Phase::kEstop;
  port_.EmergencyStop();
  if (!is_news) return;
  const std::string trouble = stop_record_.Begin(reason);
  if (!trouble.empty()) newest_.RaiseAlarm(trouble);
}

void LiveSlave::KeepStopIn(const std::filesystem::path& folder) {
  if (stop_record_.KeepIn(folder)) port_.EmergencyStop();
}

BoundaryShape LiveSlave::Shape(bool nodal_forces) {
  const std::lock_guard lock(sense_mutex_);
  return sense_->Shape(nodal_forces);
}

std::optional<JpegPicture> LiveSlave::Picture(bool overlays, int quality) {
  const double full_scale = settings_.FullScale();
  std::optional<SeenPicture> seen;
  {
    const std::lock_guard lock(sense_mutex_);
    seen = sense_->Picture(full_scale);
  }
  if (!seen) return std::nullopt;
  return JpegPicture{seen->sensed_at, EncodeJpeg(overlays ? seen->draw() : seen->plain, quality),
                     seen->plain.cols, seen->plain.rows};
}

}  // namespace palpate
