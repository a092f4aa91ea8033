#include "slave/pipeline/fingertips/tactile_slave.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <spdlog/spdlog.h>

#include "slave/capture/tactile_inbox.h"
#include "slave/capture/tactile_recording.h"
#include "slave/mechanics/make_model.h"
#include "slave/pipeline/fingertips/tactile_shape.h"
#include "slave/site/fingertips/simulated_fingers.h"

namespace palpate {
namespace {

constexpr std::array<std::string_view, 5> kKinds{"auto", "fem", "fem-hyperelastic", "fem-green",
                                                 "bem3d"};

void Refuse(const std::string& what, const std::string& accepted) {
  throw std::invalid_argument(what + ": accepted is " + accepted);
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

}  // namespace

TactileSlave::TactileSlave(const Scene& scene)
    : OperatedSlave(scene, scene.sense.tactile->rate), estimator_(scene) {
  OpenSource(scene);
  Start(scene);
}

TactileSlave::TactileSlave(const Scene& scene, std::unique_ptr<TactileSource> source,
                           TactileSenses senses)
    : OperatedSlave(scene, scene.sense.tactile->rate),
      estimator_(scene, std::move(senses)),
      source_(std::move(source)) {
  Start(scene);
}

TactileSlave::~TactileSlave() {
  StopSensing();
}

void TactileSlave::OpenSource(const Scene& scene) {
  const Tactile& tactile = *scene.sense.tactile;
  switch (tactile.source) {
    case Tactile::Source::kSimulated:
      site_ = std::make_shared<TactileSite>(scene);
      SolveAhead(scene, site_.get());
      source_ = std::make_unique<SimulatedFingers>(*site_, tactile.rate);
      break;
    case Tactile::Source::kStream:
      source_ = std::make_unique<TactileInbox>(tactile);
      break;
    case Tactile::Source::kRecording:
      source_ = OpenTactileRecording(scene, true);
      break;
  }
}

void TactileSlave::Start(const Scene& scene) {
  StartTool([site = site_](const Eigen::Vector3d& p_S_tip) {
    if (site != nullptr) site->MoveTool(p_S_tip);
  });
  SetRunning(InfoOf(estimator_.body()), ReasonOf(scene, estimator_.body()));
  StartSensing([this](const std::stop_token& stop) {
    const std::optional<TactileFrame> frame = source_->Next(stop);
    if (!frame) return false;
    const Eigen::Vector3d p_S_tip = manipulator().Tip();
    const std::lock_guard lock(touch_mutex());
    newest().Put(estimator_.Feel(*frame, p_S_tip));
    const std::string_view doubt = estimator_.shape_doubt();
    if (!doubt.empty() && told_doubts_.insert(doubt).second) {
      newest().RaiseAlarm("the object's shape is extrapolated: " + std::string(doubt));
    }
    return true;
  });
}

std::optional<Eigen::Vector3d> TactileSlave::TrueForce() const {
  if (site_ == nullptr) return std::nullopt;
  return site_->truth().front().force;
}

std::vector<StageTimes> TactileSlave::Stages() const {
  const TactileTimes& times = estimator_.times();
  return {TimesOf("tactile", times.tactile), TimesOf("contact", times.contact),
          TimesOf("mechanics", times.mechanics), TimesOf("total", times.total)};
}

ModelInfo TactileSlave::Replace(const Scene& changed, const std::function<void()>& may_adopt) {
  std::unique_ptr<TactileBody> body = TactileEstimator::Prepare(changed);  // takes its time
  ModelInfo info = InfoOf(body.get());
  may_adopt();
  const std::lock_guard lock(touch_mutex());
  estimator_.Adopt(std::move(body), changed);
  return info;
}

void TactileSlave::Apply(const ModelChange& change, ModelOptions* model) const {
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

BoundaryShape TactileSlave::Shape(bool nodal_forces) {
  const std::lock_guard lock(touch_mutex());
  return MakeTactileShape(estimator_, nodal_forces);
}

std::optional<JpegPicture> TactileSlave::Picture(bool /*overlays*/, int /*quality*/) {
  return std::nullopt;
}

TactileInbox* TactileSlave::tactile_inbox() {
  return dynamic_cast<TactileInbox*>(source_.get());
}

}  // namespace palpate
