#include "slave/pipeline/tactile_slave.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <spdlog/spdlog.h>

#include "shared/link/thread_priority.h"
#include "slave/capture/tactile_inbox.h"
#include "slave/capture/tactile_recording.h"
#include "slave/manipulator/simulated_manipulator.h"
#include "slave/mechanics/make_model.h"
#include "slave/pipeline/tactile_shape.h"
#include "slave/site/fingertip/simulated_fingers.h"

namespace palpate {
namespace {

constexpr std::array<std::string_view, 5> kKinds{"auto", "fem", "fem-hyperelastic", "fem-green",
                                                 "bem3d"};

void Refuse(const std::string& what, const std::string& accepted) {
  throw std::invalid_argument(what + ": accepted is " + accepted);
}

// Changes only what a volume's model has.
void Apply(const ModelChange& change, ModelOptions* model) {
  if (!change.kind.empty()) {
    if (std::ranges::find(kKinds, change.kind) == kKinds.end()) {
      Refuse("kind = " + change.kind, "auto, fem, fem-hyperelastic, fem-green, bem3d");
    }
    model->kind = change.kind;
  }
  if (change.elements != 0) {
    Refuse("elements = " + std::to_string(change.elements),
           "none here: a volume's mesh is the scene's");
  }
  if (!change.plane.empty()) Refuse("plane = " + change.plane, "none here: a volume has no plane");
  if (change.contact == "bonded" || change.contact == "frictionless") {
    model->contact = change.contact == "bonded" ? ContactLaw::kBonded : ContactLaw::kFrictionless;
  } else if (!change.contact.empty()) {
    Refuse("contact = " + change.contact, "bonded, frictionless");
  }
}

ModelInfo InfoOf(const TactileBody* body) {
  if (body != nullptr) return body->deformation->info();
  ModelInfo none;
  none.kind = "none";
  return none;
}

std::string ReasonOf(const Scene& scene, const TactileBody* body) {
  return body != nullptr ? ChooseModel(scene).reason
                         : "nothing says where the fingertips are, so nothing deforms";
}

// A press is as slow as its solution: the scene's own, to its full depth, is solved before anybody
// operates. Seconds.
void SolveAhead(const Scene& scene, TactileSite* site) {
  const double way = site->gap() + scene.operator_options.press_depth;
  if (std::isfinite(way)) {
    spdlog::info("the simulated site solves a press of {:.3g} mm ahead",
                 1e3 * scene.operator_options.press_depth);
    site->MoveTool(site->home() + way * site->approach());
  }
  site->MoveTool(site->home());
}

StageTimes Stage(const char* name, const LatencyHistogram& h) {
  return {name, h.Quantile(0.5), h.Quantile(0.99), h.max()};
}

}  // namespace

TactileSlave::TactileSlave(Scene scene)
    : scene_(std::move(scene)),
      estimator_(scene_),
      newest_(scene_.sense.tactile->rate, scene_.manipulator.home) {
  OpenSource();
  Start();
}

TactileSlave::TactileSlave(Scene scene, std::unique_ptr<TactileSource> source, TactileSenses senses)
    : scene_(std::move(scene)),
      estimator_(scene_, std::move(senses)),
      source_(std::move(source)),
      newest_(scene_.sense.tactile->rate, scene_.manipulator.home) {
  Start();
}

TactileSlave::~TactileSlave() {
  sample_thread_.request_stop();
  newest_.Wake();
}

void TactileSlave::OpenSource() {
  switch (scene_.sense.tactile->source) {
    case Tactile::Source::kSimulated:
      site_ = std::make_unique<TactileSite>(scene_);
      SolveAhead(scene_, site_.get());
      source_ = std::make_unique<SimulatedFingers>(*site_, scene_.sense.tactile->rate);
      break;
    case Tactile::Source::kStream:
      source_ = std::make_unique<TactileInbox>(*scene_.sense.tactile);
      break;
    case Tactile::Source::kRecording:
      source_ = OpenTactileRecording(scene_, true);
      break;
  }
}

void TactileSlave::Start() {
  manipulator_ = std::make_unique<SimulatedManipulator>(
      scene_.manipulator, [site = site_.get()](const Eigen::Vector3d& p_S_tip) {
        if (site != nullptr) site->MoveTool(p_S_tip);
      });
  port_ = std::make_unique<OperatorPort>(*manipulator_, scene_.operator_options.transform);
  model_reason_ = ReasonOf(scene_, estimator_.body());
  model_info_ = InfoOf(estimator_.body());
  sample_thread_ = std::jthread([this](const std::stop_token& stop) { WatchSamples(stop); });
  operator_watch_.emplace(*port_, [this] { return newest_.Force(); });
}

void TactileSlave::WatchSamples(const std::stop_token& stop) {
  MakeThreadRealtime(kEyesPriority);
  try {
    while (const std::optional<TactileFrame> frame = source_->Next(stop)) {
      const Eigen::Vector3d p_S_tip = manipulator_->Tip();
      const std::lock_guard lock(touch_mutex_);
      newest_.Put(estimator_.Feel(*frame, p_S_tip));
    }
    if (!stop.stop_requested()) {
      newest_.RaiseAlarm(source_->description() + ": the source has ended");
    }
  } catch (const std::exception& e) {
    newest_.RaiseAlarm(e.what());
  }
}

void TactileSlave::BeginOperating() {
  port_->BeginOperating();
}

bool TactileSlave::Command(const OperatorCommand& command) noexcept {
  return port_->Command(command, Clock::now());
}

void TactileSlave::EndOperating() {
  port_->EndOperating();
}

SlaveState TactileSlave::Compose(Time now) {
  SlaveState state = newest_.Compose(*port_, now);
  if (site_ != nullptr) state.true_force = site_->truth().front().force;
  return state;
}

Events TactileSlave::TakeEvents() {
  Events events = port_->TakeEvents();
  events.Add(newest_.TakeEvents());
  return events;
}

bool TactileSlave::WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) {
  return newest_.WaitForNewer(sensed_at, patience);
}

SlaveDescription TactileSlave::Describe() const {
  SlaveDescription description;
  {
    const std::lock_guard lock(settings_mutex_);
    description.scene = scene_;
    description.model_reason = model_reason_;
    description.model = model_info_;
  }
  description.scene.operator_options.transform = port_->transform();
  description.source = source_->description();
  description.simulated = site_ != nullptr;
  return description;
}

SlaveStatus TactileSlave::Status() const {
  SlaveStatus status;
  status.phase = port_->view().phase;
  status.commands = port_->taken();
  status.commands_refused = port_->refused();
  status.started_at = started_at_;
  TactileTimes times;
  {
    const std::lock_guard lock(touch_mutex_);
    times = estimator_.times();
  }
  status.stages = {Stage("tactile", times.tactile), Stage("contact", times.contact),
                   Stage("mechanics", times.mechanics), Stage("total", times.total)};
  newest_.Describe(&status);
  return status;
}

Scene TactileSlave::scene() const {
  const std::lock_guard lock(settings_mutex_);
  return scene_;
}

void TactileSlave::Rebuild(const Scene& changed, const std::function<void()>& may_adopt) {
  std::unique_ptr<TactileBody> body = TactileEstimator::Prepare(changed);  // takes its time
  const ModelInfo info = InfoOf(body.get());
  may_adopt();
  {
    const std::lock_guard lock(touch_mutex_);
    estimator_.Adopt(std::move(body), changed);
  }
  {
    const std::lock_guard lock(settings_mutex_);
    scene_ = changed;
    model_info_ = info;
  }
  newest_.Add(Event::kModelChanged);
}

void TactileSlave::SetModel(const ModelChange& change) {
  const std::lock_guard one_at_a_time(change_mutex_);
  RefuseWhileFollowing(*port_);
  Scene changed = scene();
  Apply(change, &changed.model);
  Rebuild(changed, [this] { RefuseWhileFollowing(*port_); });  // somebody may have begun meanwhile
  const std::lock_guard lock(settings_mutex_);
  model_reason_ = "asked for by SetModel";
}

void TactileSlave::SetParameters(const ParameterChange& change) {
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

void TactileSlave::Reset() {
  port_->Reset();
  const std::lock_guard lock(touch_mutex_);
  estimator_.Reset();
}

void TactileSlave::EmergencyStop(const std::string& reason) {
  port_->EmergencyStop();
  spdlog::warn("emergency stop: {}", reason.substr(0, 200));
}

BoundaryShape TactileSlave::Shape(bool nodal_forces) {
  const std::lock_guard lock(touch_mutex_);
  return MakeTactileShape(estimator_, nodal_forces);
}

std::optional<JpegPicture> TactileSlave::Picture(bool /*overlays*/, int /*quality*/) {
  return std::nullopt;
}

TactileInbox* TactileSlave::tactile_inbox() {
  return dynamic_cast<TactileInbox*>(source_.get());
}

}  // namespace palpate
