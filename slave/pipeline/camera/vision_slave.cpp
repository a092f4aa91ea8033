#include "slave/pipeline/camera/vision_slave.h"

#include <stdexcept>
#include <utility>

#include "slave/capture/codecs/codecs.h"
#include "slave/mechanics/make_model.h"
#include "slave/pipeline/camera/overlay.h"
#include "slave/pipeline/camera/shape.h"
#include "slave/site/camera/simulated_camera.h"
#include "slave/vision/stereo/straightening.h"

namespace palpate {
namespace {

Frame FirstPicture(FrameSource& source) {
  std::optional<Frame> first = source.Next({});
  if (!first) throw std::runtime_error(source.description() + ": no picture came");
  return *std::move(first);
}

}  // namespace

VisionSlave::VisionSlave(const Scene& scene)
    : OperatedSlave(scene, scene.sense.camera->rate),
      // A twentieth of a pixel is what the eyes resolve; slower than that is standing.
      tip_registration_(0.05 * scene.sense.camera->pixel) {
  const bool simulated = scene.sense.camera->source == Camera::Source::kSimulated;
  if (simulated) site_ = std::make_shared<SimulatedSite>(scene);
  StartTool([site = site_](const Eigen::Vector3d& p_S_tip) {
    if (site != nullptr) site->MoveTool(p_S_tip);
  });
  if (simulated) {
    site_->MoveTool(manipulator().Tip());
    source_ = std::make_unique<SimulatedCamera>(*site_, scene.sense.camera->rate);
  } else {
    source_ = OpenFrameSource(scene, true, StraighteningOf(*scene.sense.camera));
  }

  const Frame first = FirstPicture(*source_);
  // Without a template file the tool is taken to be where the manipulator stands in the first
  // picture.
  const bool cut_template = simulated || scene.sense.tip->template_file.empty();
  estimator_ = std::make_unique<Estimator>(
      scene, first, cut_template ? std::optional(manipulator().Tip()) : std::nullopt);
  registration_ = estimator_->registration();
  SetRunning(estimator_->touch().deformation->info(), ChooseModel(scene).reason);
  Publish(first, estimator_->Feel(first), manipulator().Tip());
  StartSensing([this](const std::stop_token& stop) {
    const std::optional<Frame> frame = source_->Next(stop);
    if (!frame) return false;
    const Eigen::Vector3d p_S_encoders = manipulator().Tip();
    const std::lock_guard lock(touch_mutex());
    Publish(*frame, estimator_->Feel(*frame), p_S_encoders);
    return true;
  });
}

VisionSlave::~VisionSlave() {
  StopSensing();
}

void VisionSlave::Publish(const Frame& frame, const ContactEstimate& felt,
                          const Eigen::Vector3d& p_S_encoders) {
  if (site_ != nullptr && felt.validity != Validity::kTrackingLost) {
    tip_registration_.Add(felt.p_S_tip, p_S_encoders);
    port().SetRegistration(tip_registration_.offset());
  }
  {
    const std::lock_guard lock(picture_mutex_);
    newest_frame_ = frame;
    newest_observation_ = estimator_->observation();
    newest_contour_I_.assign(newest_observation_.contour_I.begin(),
                             newest_observation_.contour_I.end());
    newest_window_ = estimator_->eyes().search_window();
  }
  newest().Put(felt);
}

std::optional<Eigen::Vector3d> VisionSlave::TrueForce() const {
  if (site_ == nullptr) return std::nullopt;
  return site_->truth().force;
}

std::vector<StageTimes> VisionSlave::Stages() const {
  const StageHistograms& times = estimator_->times();
  return {TimesOf("vision", times.vision), TimesOf("contact", times.contact),
          TimesOf("mechanics", times.mechanics), TimesOf("total", times.total)};
}

ModelInfo VisionSlave::Replace(const Scene& changed, const std::function<void()>& may_adopt) {
  std::unique_ptr<TouchModel> touch = estimator_->Prepare(changed);  // takes its time
  ModelInfo info = touch->deformation->info();
  may_adopt();
  const std::lock_guard lock(touch_mutex());
  estimator_->Adopt(std::move(touch), changed);
  return info;
}

void VisionSlave::Apply(const ModelChange& change, ModelOptions* model) const {
  const auto refuse = [](const std::string& what, const std::string& accepted) {
    throw std::invalid_argument(what + ": accepted is " + accepted);
  };
  if (!change.kind.empty() && change.kind != "bem2d" && change.kind != "auto") {
    refuse("kind = " + change.kind, "bem2d, auto");
  }
  if (!change.kind.empty()) model->kind = change.kind;
  if (change.elements != 0) {
    if (change.elements < 3 || change.elements > 4000) {
      refuse("elements = " + std::to_string(change.elements), "3 to 4000");
    }
    model->elements = change.elements;
  }
  if (change.plane == "stress" || change.plane == "strain") {
    model->plane = change.plane == "stress" ? Plane::kStress : Plane::kStrain;
  } else if (!change.plane.empty()) {
    refuse("plane = " + change.plane, "stress, strain");
  }
  if (change.contact == "bonded" || change.contact == "frictionless") {
    model->contact = change.contact == "bonded" ? ContactLaw::kBonded : ContactLaw::kFrictionless;
  } else if (!change.contact.empty()) {
    refuse("contact = " + change.contact, "bonded, frictionless");
  }
}

BoundaryShape VisionSlave::Shape(bool nodal_forces) {
  const std::lock_guard lock(touch_mutex());
  return MakeShape(estimator_->touch(), estimator_->registration().X_SO, estimator_->felt(),
                   nodal_forces);
}

std::optional<JpegPicture> VisionSlave::Picture(bool overlays, int quality) {
  Frame frame;
  Overlay overlay;
  const ContactEstimate felt = newest().Get();
  {
    const std::lock_guard lock(picture_mutex_);
    if (newest_frame_.image.empty()) return std::nullopt;
    frame = newest_frame_;
    overlay = {newest_contour_I_, newest_window_, newest_observation_.tip, felt.force, {0, 0}};
  }
  if (overlay.force) {
    overlay.force_I =
        ForceArrow(estimator_->view(), felt.p_S_tip, *overlay.force, FullScale(), frame.image.rows);
  }
  JpegPicture picture;
  picture.sensed_at = frame.sensed_at;
  picture.width = frame.image.cols;
  picture.height = frame.image.rows;
  picture.jpeg = EncodeJpeg(overlays ? DrawOverlay(frame.image, overlay) : frame.image, quality);
  return picture;
}

}  // namespace palpate
