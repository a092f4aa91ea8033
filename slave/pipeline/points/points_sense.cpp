#include "slave/pipeline/points/points_sense.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include <spdlog/fmt/fmt.h>

#include "slave/mechanics/factory/choose_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mesh/files/mesh_file.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/manipulator_agreement/arm_lag.h"

namespace palpate {
namespace {

std::unique_ptr<StereoSource> OpenPairSource(const Scene& scene, const SenseInputs& inputs) {
  if (inputs.player != nullptr) return inputs.player->OpenPairs();
  if (inputs.images != nullptr) return inputs.images->OpenPairs();
  return OpenStereo(scene);
}

std::unique_ptr<StereoSource> OpenTappedPairs(const Scene& scene, const SenseInputs& inputs) {
  return Tapped(OpenPairSource(scene, inputs), inputs.tap);
}

// Returns the shape of an object that is tracked as a whole without a model: the surface of the
// scene's mesh, frame O. Empty if the scene has none.
SurfaceMesh FollowedSurface(const Scene& scene) {
  const auto* geometry = std::get_if<MeshFileGeometry>(&scene.object.geometry);
  if (geometry == nullptr) return {};
  MeshFile file = ReadMeshFile(geometry->file, geometry->unit);
  auto* surface = std::get_if<SurfaceMesh>(&file.mesh);
  return surface != nullptr ? std::move(*surface) : SurfaceMesh{};
}

// The properties of a rig that determine its depth resolution.
std::string InWords(const StereoRig& rig) {
  return fmt::format("stereo pair, baseline {:.3g} mm, focal length {:.0f} px, {} x {} px",
                     1e3 * rig.baseline(), rig.left.fx, rig.left.size[0], rig.left.size[1]);
}

std::string InWords(const PointTracking& points) {
  switch (points.track) {
    case PointTracking::Track::kDots:
      return fmt::format("an array of {} dots is tracked", points.count);
    case PointTracking::Track::kTexture:
      return fmt::format("{} windows of texture are tracked",
                         points.at.empty() ? fmt::format("up to {}", points.count)
                                           : fmt::format("{}", points.at.size()));
    case PointTracking::Track::kSurface:
      break;
  }
  return "the surface is tracked in the depth images";
}

}  // namespace

bool EstimatesForce(const Scene& scene) {
  return IsHeld(scene.object) && scene.tool.has_value();
}

PointsSense::PointsSense(const Scene& scene, const SenseInputs& inputs)
    : PointsSense(scene, OpenTappedPairs(scene, inputs)) {}

PointsSense::PointsSense(const Scene& scene, std::unique_ptr<StereoSource> source)
    : scene_(scene),
      source_(std::move(source)),
      rig_(RigOf(scene)),
      tracker_(MakeSurfacePointTracker(scene, rig_)) {
  if (EstimatesForce(scene)) {
    estimator_ = std::make_unique<SurfaceEstimator>(scene);
    held_ = HeldVertices(scene, estimator_->body().surface());
  } else {
    followed_ = FollowedSurface(scene);
  }
}

bool PointsSense::Acquire(const std::stop_token& stop) {
  std::optional<StereoPair> pair = source_->Next(stop);
  if (!pair) return false;
  if (seen_ == nullptr) RequireRigFits(scene_, rig_, *pair);
  next_ = *std::move(pair);
  return true;
}

void PointsSense::Process() noexcept {
  Stopwatch lap;
  rest_known_ = tracker_->at_rest_known();
  seen_ = &tracker_->Process(next_);
  look_us_ = lap.Lap();
}

const ContactEstimate& PointsSense::Estimate(const TipReading& encoders) noexcept {
  Stopwatch lap;
  estimate_ = &EstimateContact(encoders);
  times_.look.Add(look_us_);
  times_.checks.Add(tracker_->checks_us());
  times_.total.Add(look_us_ + lap.Lap());
  shown_ = next_;
  overlay_ = MakePointsOverlay(*tracker_, *seen_, *estimate_);
  return *estimate_;
}

const ContactEstimate& PointsSense::EstimateContact(const TipReading& encoders) noexcept {
  if (rest_known_ || seen_->found) {
    const auto lag = encoders.frame ? std::optional(kArmLag) : std::nullopt;
    return estimator_ ? estimator_->Estimate(*seen_, encoders.p_S_tip, lag)
                      : place_.Estimate(*seen_);
  }
  before_rest_.sample = seen_->sequence;
  before_rest_.sensed_at = seen_->sensed_at;
  before_rest_.p_S_tip = before_rest_.p_S_contact = encoders.p_S_tip;
  // The cells of a depth image are unknown before the baseline.
  sees_rest_ =
      scene_.sense.Find<DepthImages>() || std::ranges::any_of(seen_->points, &SurfacePoint::seen);
  return before_rest_;
}

BoundaryShape PointsSense::Shape(const ShapeParts& parts) {
  const SurfaceMesh& surface = estimator_ ? estimator_->body().surface() : followed_;
  const Eigen::Isometry3d& X_SO = scene_.object.X_SO;
  BoundaryShape shape = ShapeAsOf(*estimate_, 3);
  shape.fixed_nodes = held_;
  for (const auto& triangle : surface.triangles) {
    for (const int node : triangle) shape.elements.push_back(static_cast<std::uint32_t>(node));
  }
  for (const Eigen::Vector3d& p_O : surface.nodes) Append(&shape.rest, X_SO * p_O);
  if (!estimator_) {
    for (const auto& p_O : surface.nodes) Append(&shape.positions, X_SO * p_O + place_.moved());
    return shape;  // this model has no deformation
  }
  std::vector<Eigen::Vector3d> per_node;  // frame S
  estimator_->DeformedNodes(&per_node);
  for (const Eigen::Vector3d& p_S : per_node) Append(&shape.positions, p_S);
  if (parts.field) shape.field = FieldOf(surface, shape.elements, per_node);
  if (!parts.nodal_forces || !estimate_->force) return shape;
  estimator_->NodalForces(&per_node);
  for (const Eigen::Vector3d& f_S : per_node) Append(&shape.nodal_forces, f_S);
  return shape;
}

DisplacementField PointsSense::FieldOf(const SurfaceMesh& surface,
                                       const std::vector<std::uint32_t>& triangles,
                                       const std::vector<Eigen::Vector3d>& p_S) const {
  const Eigen::Isometry3d X_OS = scene_.object.X_SO.inverse();
  const Eigen::Vector2d nowhere = Eigen::Vector2d::Constant(std::nan(""));
  DisplacementField field{.triangles = triangles};
  for (std::size_t i = 0; i < p_S.size(); ++i) {
    const Eigen::Vector3d& p_O = surface.nodes[i];
    Append(&field, p_O, X_OS * p_S[i] - p_O, tracker_->Project(p_S[i]).value_or(nowhere));
  }
  return field;
}

std::optional<OverlaidImage> PointsSense::Image(double full_scale) const {
  if (shown_.left.empty()) return std::nullopt;
  return OverlaidImage{shown_.sensed_at, AsImage(shown_.left),
                       [left = shown_.left, overlay = overlay_, full_scale] {
                         return DrawPoints(left, overlay, full_scale);
                       }};
}

void PointsSense::Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) {
  if (!estimator_) return;
  estimator_->Adopt(
      std::unique_ptr<LoadIdentifier>(static_cast<LoadIdentifier*>(prepared.release())), changed);
  held_ = HeldVertices(changed, estimator_->body().surface());
}

void PointsSense::Reset(const std::function<bool()>& /*is_disengaged*/) {
  tracker_->Reset();
  if (estimator_) estimator_->Reset();
  place_.Reset();
}

std::string_view PointsSense::why() const {
  if (estimate_ == &before_rest_)
    return sees_rest_ ? "the rest shape is being measured" : WhyNotFound(scene_);
  if (estimate_->validity == Validity::kValid) return {};
  if (estimate_->validity == Validity::kTrackingLost && !(seen_->found && estimator_)) {
    return "the points are not detected";
  }
  return estimator_ ? estimator_->load().reason
                    : "the object has no fixed boundary: its force is unknown";
}

SenseInfo PointsSense::info() const {
  SenseInfo info;
  info.source = source_->description();
  info.samples = "pairs";
  info.has_force_estimate = estimator_ != nullptr;
  info.model.kind = "none";
  if (estimator_) info.model = estimator_->body().info();
  info.reason = estimator_ ? ChooseModel(scene_).reason
                           : "the object is tracked without a model: no force is estimated";
  if (scene_.sense.Find<StereoCameras>()) info.remarks.push_back(InWords(rig_));
  info.remarks.push_back(InWords(*scene_.sense.Find<PointTracking>()));
  info.remarks.push_back(fmt::format(
      "the rest shape comes from the first {}: nothing may touch the object until then",
      tracker_->rest_images() == 1 ? "pair of images"
                                   : fmt::format("{} images", tracker_->rest_images())));
  if (!estimator_) info.remarks.push_back(info.reason);
  if (estimator_) info.object = ClassOf(scene_.object.geometry);
  if (info.object == ObjectClass::kVolume) {
    info.remarks.emplace_back(
        "the model is then computed for each point in view: the force is unknown until then");
  }
  return info;
}

std::vector<StageTimes> PointsSense::Stages() const {
  return {TimesOf(tracker_->stage(), times_.look), TimesOf("checks", times_.checks),
          TimesOf("mechanics", estimator_ ? estimator_->times() : LatencyHistogram{}),
          TimesOf("total", times_.total)};
}

}  // namespace palpate
