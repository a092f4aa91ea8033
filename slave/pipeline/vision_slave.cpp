#include "slave/pipeline/vision_slave.h"

#include <algorithm>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/thread_priority.h"
#include "slave/capture/jpeg.h"
#include "slave/manipulator/simulated_manipulator.h"
#include "slave/mechanics/make_model.h"
#include "slave/pipeline/overlay.h"
#include "slave/pipeline/shape.h"
#include "slave/site/simulated_camera.h"

namespace palpate {
namespace {

Frame FirstPicture(FrameSource& source) {
  std::optional<Frame> first = source.Next({});
  if (!first) throw std::runtime_error(source.description() + ": no picture came");
  return *std::move(first);
}

}  // namespace

VisionSlave::VisionSlave(Scene scene)
    : scene_(std::move(scene)),
      started_at_(Clock::now()),
      // A twentieth of a pixel is what the eyes resolve; slower than that is standing.
      tip_registration_(0.05 * scene_.sense.camera->pixel),
      newest_(scene_.sense.camera->rate, scene_.manipulator.home) {
  const bool simulated = scene_.sense.camera->source == Camera::Source::kSimulated;
  if (simulated) site_ = std::make_unique<SimulatedSite>(scene_);
  manipulator_ = std::make_unique<SimulatedManipulator>(
      scene_.manipulator, [site = site_.get()](const Eigen::Vector3d& p_S_tip) {
        if (site != nullptr) site->MoveTool(p_S_tip);
      });
  if (simulated) {
    site_->MoveTool(manipulator_->Tip());
    source_ = std::make_unique<SimulatedCamera>(*site_, scene_.sense.camera->rate);
  } else {
    source_ = OpenFrameSource(scene_, true);
  }
  port_ = std::make_unique<OperatorPort>(*manipulator_, scene_.operator_options.transform);
  model_reason_ = ChooseModel(scene_).reason;

  const Frame first = FirstPicture(*source_);
  // Without a template file the tool is taken to be where the manipulator stands in the first
  // picture.
  const bool cut_template = simulated || scene_.sense.tip->template_file.empty();
  estimator_ = std::make_unique<Estimator>(
      scene_, first, cut_template ? std::optional(manipulator_->Tip()) : std::nullopt);
  registration_ = estimator_->registration();
  model_info_ = estimator_->touch().deformation->info();
  Publish(first, estimator_->Feel(first), manipulator_->Tip());

  picture_thread_ = std::jthread([this](const std::stop_token& stop) { WatchPictures(stop); });
  operator_watch_.emplace(*port_, [this] { return newest_.Force(); });
}

VisionSlave::~VisionSlave() {
  picture_thread_.request_stop();
  newest_.Wake();
}

void VisionSlave::WatchPictures(const std::stop_token& stop) {
  MakeThreadRealtime(kEyesPriority);
  try {
    while (std::optional<Frame> frame = source_->Next(stop)) {
      const Eigen::Vector3d p_S_encoders = manipulator_->Tip();
      const std::lock_guard lock(touch_mutex_);
      Publish(*frame, estimator_->Feel(*frame), p_S_encoders);
    }
    if (!stop.stop_requested())
      newest_.RaiseAlarm(source_->description() + ": the source has ended");
  } catch (const std::exception& e) {
    newest_.RaiseAlarm(e.what());
  }
}

void VisionSlave::Publish(const Frame& frame, const Felt& felt,
                          const Eigen::Vector3d& p_S_encoders) {
  if (site_ != nullptr && felt.validity != Validity::kTrackingLost) {
    tip_registration_.Add(felt.p_S_tip, p_S_encoders);
    port_->SetRegistration(tip_registration_.offset());
  }
  {
    const std::lock_guard lock(picture_mutex_);
    newest_frame_ = frame;
    newest_observation_ = estimator_->observation();
    newest_contour_I_.assign(newest_observation_.contour_I.begin(),
                             newest_observation_.contour_I.end());
    newest_window_ = estimator_->eyes().search_window();
  }
  newest_.Put(felt);
}

void VisionSlave::BeginOperating() {
  port_->BeginOperating();
}

bool VisionSlave::Command(const OperatorCommand& command) noexcept {
  return port_->Command(command, Clock::now());
}

void VisionSlave::EndOperating() {
  port_->EndOperating();
}

SlaveState VisionSlave::Compose(Time now) {
  SlaveState state = newest_.Compose(*port_, now);
  if (site_ != nullptr) state.true_force = site_->truth().force;
  return state;
}

Events VisionSlave::TakeEvents() {
  Events events = port_->TakeEvents();
  events.Add(newest_.TakeEvents());
  return events;
}

bool VisionSlave::WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) {
  return newest_.WaitForNewer(sensed_at, patience);
}

SlaveDescription VisionSlave::Describe() const {
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

SlaveStatus VisionSlave::Status() const {
  SlaveStatus status;
  status.phase = port_->view().phase;
  status.commands = port_->taken();
  status.commands_refused = port_->refused();
  status.started_at = started_at_;
  StageHistograms times;
  {
    const std::lock_guard lock(touch_mutex_);
    times = estimator_->times();
  }
  const auto stage = [](const char* name, const LatencyHistogram& h) {
    return StageTimes{name, h.Quantile(0.5), h.Quantile(0.99), h.max()};
  };
  status.stages = {stage("vision", times.vision), stage("contact", times.contact),
                   stage("mechanics", times.mechanics), stage("total", times.total)};
  newest_.Describe(&status);
  return status;
}

Scene VisionSlave::scene() const {
  const std::lock_guard lock(settings_mutex_);
  return scene_;
}

void VisionSlave::Rebuild(const Scene& changed, const std::function<void()>& may_adopt) {
  std::unique_ptr<TouchModel> touch = estimator_->Prepare(changed);  // takes its time
  const ModelInfo info = touch->deformation->info();
  may_adopt();
  {
    const std::lock_guard lock(touch_mutex_);
    estimator_->Adopt(std::move(touch), changed);
  }
  {
    const std::lock_guard lock(settings_mutex_);
    scene_ = changed;
    model_info_ = info;
  }
  newest_.Add(Event::kModelChanged);
}

void VisionSlave::SetModel(const ModelChange& change) {
  const auto refuse = [](const std::string& what, const std::string& accepted) {
    throw std::invalid_argument(what + ": accepted is " + accepted);
  };
  const std::lock_guard one_at_a_time(change_mutex_);
  RefuseWhileFollowing(*port_);
  Scene changed = scene();
  ModelOptions& model = changed.model;
  if (!change.kind.empty() && change.kind != "bem2d" && change.kind != "auto") {
    refuse("kind = " + change.kind, "bem2d, auto");
  }
  if (!change.kind.empty()) model.kind = change.kind;
  if (change.elements != 0) {
    if (change.elements < 3 || change.elements > 4000) {
      refuse("elements = " + std::to_string(change.elements), "3 to 4000");
    }
    model.elements = change.elements;
  }
  if (change.plane == "stress" || change.plane == "strain") {
    model.plane = change.plane == "stress" ? Plane::kStress : Plane::kStrain;
  } else if (!change.plane.empty()) {
    refuse("plane = " + change.plane, "stress, strain");
  }
  if (change.contact == "bonded" || change.contact == "frictionless") {
    model.contact = change.contact == "bonded" ? ContactLaw::kBonded : ContactLaw::kFrictionless;
  } else if (!change.contact.empty()) {
    refuse("contact = " + change.contact, "bonded, frictionless");
  }
  Rebuild(changed, [this] { RefuseWhileFollowing(*port_); });  // somebody may have begun meanwhile
  const std::lock_guard lock(settings_mutex_);
  model_reason_ = "asked for by SetModel";
}

void VisionSlave::SetParameters(const ParameterChange& change) {
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

void VisionSlave::Reset() {
  port_->Reset();
  const std::lock_guard lock(touch_mutex_);
  estimator_->Reset();
}

void VisionSlave::EmergencyStop(const std::string& reason) {
  port_->EmergencyStop();
  spdlog::warn("emergency stop: {}", reason.substr(0, 200));
}

BoundaryShape VisionSlave::Shape(bool nodal_forces) {
  const std::lock_guard lock(touch_mutex_);
  const Felt& felt = estimator_->felt();
  BoundaryShape shape =
      MakeShape(estimator_->touch(), estimator_->registration().X_SO, felt, nodal_forces);
  return shape;
}

std::optional<JpegPicture> VisionSlave::Picture(bool overlays, int quality) {
  Frame frame;
  Overlay overlay;
  double full_scale = 0;  // what the hand can show, at the tool [N]
  {
    const std::lock_guard lock(settings_mutex_);
    full_scale = scene_.operator_options.force_limit / port_->transform().force_scale;
  }
  const Felt felt = newest_.Get();
  {
    const std::lock_guard lock(picture_mutex_);
    if (newest_frame_.image.empty()) return std::nullopt;
    frame = newest_frame_;
    overlay = {newest_contour_I_, newest_window_, newest_observation_.tip, felt.force, {0, 0}};
  }
  if (overlay.force) {
    overlay.force_I =
        ForceArrow(estimator_->view(), felt.p_S_tip, *overlay.force, full_scale, frame.image.rows);
  }
  JpegPicture picture;
  picture.sensed_at = frame.sensed_at;
  picture.width = frame.image.cols;
  picture.height = frame.image.rows;
  picture.jpeg = EncodeJpeg(overlays ? DrawOverlay(frame.image, overlay) : frame.image, quality);
  return picture;
}

}  // namespace palpate
