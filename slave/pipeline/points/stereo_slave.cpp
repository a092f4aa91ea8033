#include "slave/pipeline/points/stereo_slave.h"

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <spdlog/spdlog.h>

#include "slave/capture/codecs/codecs.h"
#include "slave/pipeline/points/surface_shape.h"
#include "slave/pipeline/stopwatch.h"
#include "slave/site/points/simulated_pair.h"

namespace palpate {
namespace {

constexpr std::array<std::string_view, 3> kMembraneKinds{"auto", "plate", "plate-large"};
constexpr std::array<std::string_view, 5> kVolumeKinds{"auto", "fem", "fem-hyperelastic",
                                                       "fem-green", "bem3d"};

bool IsSimulated(const Scene& scene) {
  return scene.sense.stereo && scene.sense.stereo->source == StereoCameras::Source::kSimulated;
}

[[noreturn]] void Refuse(const std::string& what, const std::string& accepted) {
  throw std::invalid_argument(what + ": accepted is " + accepted);
}

std::string Listed(std::span<const std::string_view> words) {
  std::string list;
  for (const std::string_view word : words) list += (list.empty() ? "" : ", ") + std::string(word);
  return list;
}

// What is not solved yet is guessed: the scene's own press, to its full depth, is solved before
// anybody operates, which takes seconds; those elsewhere while the slave runs.
void SolveAhead(const Scene& scene, StereoSite* site) {
  const Eigen::Vector3d& p_S_home = scene.manipulator.home;
  if (EstimatesForce(scene)) {
    const Eigen::Vector3d n_S = scene.object.X_SO.linear().col(2);
    const double height = n_S.dot(p_S_home - scene.object.X_SO.translation());
    const double depth = scene.operator_options.press_depth;
    spdlog::info("the simulated site solves a press of {:.3g} mm ahead", 1e3 * depth);
    site->MoveTool(p_S_home - (height + depth) * n_S);
  }
  site->MoveTool(p_S_home);
  site->SolveEverywhere();
}

}  // namespace

StereoSlave::StereoSlave(const Scene& scene)
    : OperatedSlave(scene, SensorRate(scene.sense)),
      rig_(RigOf(scene)),
      eyes_(MakeSurfacePointTracker(scene, rig_)),
      teller_(scene) {
  OpenSource(scene);
  Start(scene);
}

StereoSlave::StereoSlave(const Scene& scene, std::unique_ptr<StereoSource> source)
    : OperatedSlave(scene, SensorRate(scene.sense)),
      rig_(RigOf(scene)),
      eyes_(MakeSurfacePointTracker(scene, rig_)),
      teller_(scene),
      source_(std::move(source)) {
  Start(scene);
}

StereoSlave::~StereoSlave() {
  StopSensing();
}

void StereoSlave::OpenSource(const Scene& scene) {
  if (!IsSimulated(scene)) {
    source_ = OpenStereoFiles(scene, true);
    return;
  }
  site_ = std::make_shared<StereoSite>(scene);
  SolveAhead(scene, site_.get());
  source_ = std::make_unique<SimulatedPair>(*site_, SensorRate(scene.sense));
}

void StereoSlave::Start(const Scene& scene) {
  StartTool([site = site_](const Eigen::Vector3d& p_S_tip) {
    if (site != nullptr) site->MoveToolAtOnce(p_S_tip);
  });
  SetRunning(teller_.info(), teller_.reason());
  X_SO_ = scene.object.X_SO;
  if (!EstimatesForce(scene)) followed_ = FollowedSurface(scene);
  const std::optional<StereoPair> first = source_->Next({});
  if (!first) throw std::runtime_error(source_->description() + ": no pictures came");
  RequireRigFits(scene, rig_, *first);
  Look(*first);
  StartSensing([this](const std::stop_token& stop) {
    const std::optional<StereoPair> pair = source_->Next(stop);
    if (pair) Look(*pair);
    return pair.has_value();
  });
}

void StereoSlave::Look(const StereoPair& pair) {
  const bool reset = reset_wanted_.exchange(false);
  if (reset) eyes_->Reset();
  Stopwatch lap;
  const Eigen::Vector3d p_S_tip = manipulator().Tip();
  const bool rest_known = eyes_->at_rest_known();
  const SurfaceObservation& seen = eyes_->Look(pair);
  const double look_us = lap.Lap();
  ContactEstimate felt;
  {
    const std::lock_guard lock(touch_mutex());
    if (reset) teller_.Reset();
    felt = teller_.Feel(seen, rest_known || seen.found, p_S_tip);
    look_times_.Add(look_us);
    total_times_.Add(look_us + lap.Lap());
  }
  PointsOverlay overlay = MakePointsOverlay(*eyes_, seen, felt, FullScale(), pair.left.rows);
  {
    const std::lock_guard lock(picture_mutex_);
    newest_pair_ = pair;
    newest_overlay_ = std::move(overlay);
  }
  newest().Put(felt);
}

SlaveState StereoSlave::Compose(Time now) {
  SlaveState state = OperatedSlave::Compose(now);
  if (teller_.estimator() != nullptr) state.local_model = LocalNow();
  return state;
}

// While a pair is being felt, the model of a moment ago will do.
LocalModel StereoSlave::LocalNow() {
  const std::unique_lock touch(touch_mutex(), std::try_to_lock);
  const std::lock_guard lock(local_mutex_);
  if (touch.owns_lock()) newest_local_ = teller_.estimator()->LocalAt(manipulator().Tip());
  return newest_local_;
}

std::optional<Eigen::Vector3d> StereoSlave::TrueForce() const {
  if (site_ == nullptr || teller_.estimator() == nullptr) return std::nullopt;
  const MembraneTruth truth = site_->truth();
  return truth.solved ? std::optional(truth.force) : std::nullopt;
}

std::vector<StageTimes> StereoSlave::Stages() const {
  return {TimesOf(eyes_->stage(), look_times_), TimesOf("mechanics", teller_.mechanics()),
          TimesOf("total", total_times_)};
}

void StereoSlave::Apply(const ModelChange& change, ModelOptions* model) const {
  if (teller_.estimator() == nullptr)
    Refuse("kind = " + change.kind, "none: no force is told here");
  const bool is_membrane = std::holds_alternative<MembraneGeometry>(scene().object.geometry);
  const std::span<const std::string_view> kinds =
      is_membrane ? std::span<const std::string_view>(kMembraneKinds)
                  : std::span<const std::string_view>(kVolumeKinds);
  if (!change.kind.empty()) {
    if (std::ranges::find(kinds, change.kind) == kinds.end()) {
      Refuse("kind = " + change.kind, Listed(kinds));
    }
    model->kind = change.kind;
  }
  if (change.elements != 0) {
    Refuse("elements = " + std::to_string(change.elements), "none here: the mesh is the scene's");
  }
  if (!change.plane.empty()) Refuse("plane = " + change.plane, "none here");
  if (!change.contact.empty()) Refuse("contact = " + change.contact, "none here");
}

ModelInfo StereoSlave::Replace(const Scene& changed, const std::function<void()>& may_adopt) {
  if (teller_.estimator() == nullptr) {
    may_adopt();
    return teller_.info();
  }
  std::unique_ptr<LoadIdentifier> body = MakeLoadIdentifier(changed);  // takes its time
  ModelInfo info = body->info();
  may_adopt();
  const std::lock_guard lock(touch_mutex());
  teller_.estimator()->Adopt(std::move(body), changed);
  return info;
}

BoundaryShape StereoSlave::Shape(bool nodal_forces) {
  const std::lock_guard lock(touch_mutex());
  if (teller_.estimator() != nullptr)
    return MakeSurfaceShape(*teller_.estimator(), teller_.felt(), nodal_forces);
  return MakeFollowedShape(followed_, X_SO_, teller_.felt(), teller_.place().moved());
}

std::optional<JpegPicture> StereoSlave::Picture(bool overlays, int quality) {
  StereoPair pair;
  PointsOverlay overlay;
  {
    const std::lock_guard lock(picture_mutex_);
    pair = newest_pair_;
    overlay = newest_overlay_;
  }
  if (pair.left.empty()) return std::nullopt;
  JpegPicture picture;
  picture.sensed_at = pair.sensed_at;
  picture.width = pair.left.cols;
  picture.height = pair.left.rows;
  picture.jpeg =
      EncodeJpeg(overlays ? DrawPoints(pair.left, overlay) : AsPicture(pair.left), quality);
  return picture;
}

}  // namespace palpate
