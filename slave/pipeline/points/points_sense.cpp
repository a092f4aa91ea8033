#include "slave/pipeline/points/points_sense.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include <opencv2/imgproc.hpp>
#include <spdlog/fmt/fmt.h>

#include "shared/mesh/files/mesh_file.h"
#include "slave/checks/points/points_limits.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/base/overlay_words.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/manipulator_agreement/arm_lag.h"

namespace palpate {
namespace {

std::unique_ptr<StereoSource> OpenSource(const Scene& scene, const Pace& pace) {
  if (pace.player != nullptr) return pace.player->OpenPairs();
  if (pace.duration > 0) {
    throw std::invalid_argument(fmt::format(
        "--duration: accepted for a simulated target that moves on a path; the files of {} end on "
        "their own",
        scene.file.string()));
  }
  if (pace.pictures != nullptr) return pace.pictures->OpenPairs();
  return OpenStereo(scene, pace.is_live);
}

std::unique_ptr<StereoSource> Open(const Scene& scene, const Pace& pace) {
  return Tapped(OpenSource(scene, pace), pace.tap);
}

// Of an object that is followed as a whole, without a model: the surface of the scene's mesh, frame
// O. Empty where the scene has none.
SurfaceMesh FollowedSurface(const Scene& scene) {
  const auto* geometry = std::get_if<MeshFileGeometry>(&scene.object.geometry);
  if (geometry == nullptr) return {};
  MeshFile file = ReadMeshFile(geometry->file, geometry->unit);
  auto* surface = std::get_if<SurfaceMesh>(&file.mesh);
  return surface != nullptr ? std::move(*surface) : SurfaceMesh{};
}

// Of a rig: what decides how well it sees depth.
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

const cv::Scalar kSeenColour(80, 200, 80), kLostColour(60, 60, 240), kLoadColour(40, 140, 255);
// Of the drawing: a ring at full scale by the image's height [-], the largest share of full scale
// [-], the step that shows the direction of a force [m]. [by definition]
constexpr double kRing = 0.1, kMostShare = 1.5, kShortStep = 1e-3;

// Far outside stays outside, and drawable.
cv::Point Round(const Eigen::Vector2d& p) {
  const Eigen::Vector2d near = p.cwiseMax(-1e4).cwiseMin(1e4);
  return {static_cast<int>(std::lround(near.x())), static_cast<int>(std::lround(near.y()))};
}

std::string ForceInWords(const PointsOverlay& overlay) {
  if (!overlay.force) return "force unknown";
  return fmt::format("{:.3g} N +- {:.2g}  {}", *overlay.force, overlay.sigma, overlay.validity);
}

double ShareOf(const PointsOverlay& overlay, double full_scale) {
  const bool has_share = overlay.force && *overlay.force > 0 && full_scale > 0;
  return has_share ? std::fmin(kMostShare, *overlay.force / full_scale) : 0;
}

}  // namespace

bool EstimatesForce(const Scene& scene) {
  return IsHeld(scene.object) && scene.tool.has_value();
}

PointsSense::PointsSense(const Scene& scene, const Pace& pace)
    : PointsSense(scene, Open(scene, pace)) {
  arm_lag_ = ArmLag(pace, PointsLimits::kMostLag);
}

PointsSense::PointsSense(const Scene& scene, std::unique_ptr<StereoSource> source)
    : scene_(scene),
      source_(std::move(source)),
      rig_(RigOf(scene)),
      eyes_(MakeSurfacePointTracker(scene, rig_)) {
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
  rest_known_ = eyes_->at_rest_known();
  seen_ = &eyes_->Process(next_);
  look_us_ = lap.Lap();
}

const ContactEstimate& PointsSense::Estimate(const Eigen::Vector3d& p_S_tip) noexcept {
  Stopwatch lap;
  felt_ = &EstimateContact(p_S_tip);
  times_.look.Add(look_us_);
  times_.checks.Add(eyes_->checks_us());
  times_.total.Add(look_us_ + lap.Lap());
  shown_ = next_;
  overlay_ = MakePointsOverlay(*eyes_, *seen_, *felt_);
  return *felt_;
}

const ContactEstimate& PointsSense::EstimateContact(const Eigen::Vector3d& p_S_tip) noexcept {
  if (rest_known_ || seen_->found) {
    return estimator_ ? estimator_->Estimate(*seen_, p_S_tip, arm_lag_) : place_.Estimate(*seen_);
  }
  before_rest_.sample = seen_->sequence;
  before_rest_.sensed_at = seen_->sensed_at;
  before_rest_.p_S_tip = before_rest_.p_S_contact = p_S_tip;
  // The cells of a depth picture are not known before the rest frame.
  sees_rest_ =
      scene_.sense.Find<DepthPictures>() || std::ranges::any_of(seen_->points, &SurfacePoint::seen);
  return before_rest_;
}

BoundaryShape PointsSense::Shape(bool nodal_forces) {
  const SurfaceMesh& surface = estimator_ ? estimator_->body().surface() : followed_;
  const Eigen::Isometry3d& X_SO = scene_.object.X_SO;
  BoundaryShape shape = ShapeAsOf(*felt_, 3);
  shape.fixed_nodes = held_;
  for (const auto& triangle : surface.triangles) {
    for (const int node : triangle) shape.elements.push_back(static_cast<std::uint32_t>(node));
  }
  for (const Eigen::Vector3d& p_O : surface.nodes) Append(&shape.rest, X_SO * p_O);
  if (!estimator_) {
    for (const auto& p_O : surface.nodes) Append(&shape.positions, X_SO * p_O + place_.moved());
    return shape;
  }
  std::vector<Eigen::Vector3d> per_node;  // frame S
  estimator_->DeformedNodes(&per_node);
  for (const Eigen::Vector3d& p_S : per_node) Append(&shape.positions, p_S);
  if (!nodal_forces || !felt_->force) return shape;
  estimator_->NodalForces(&per_node);
  for (const Eigen::Vector3d& f_S : per_node) Append(&shape.nodal_forces, f_S);
  return shape;
}

std::optional<SeenPicture> PointsSense::Picture(double full_scale) const {
  if (shown_.left.empty()) return std::nullopt;
  return SeenPicture{shown_.sensed_at, AsPicture(shown_.left),
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

void PointsSense::Reset() {
  eyes_->Reset();
  if (estimator_) estimator_->Reset();
  place_.Reset();
}

std::string_view PointsSense::why() const {
  if (felt_ == &before_rest_)
    return sees_rest_ ? "the rest shape is being measured" : WhyNotFound(scene_);
  if (felt_->validity == Validity::kValid) return {};
  if (felt_->validity == Validity::kTrackingLost && !(seen_->found && estimator_)) {
    return "the points are not detected";
  }
  return estimator_ ? estimator_->load().reason
                    : "the object has no fixed boundary: its force is unknown";
}

SenseInfo PointsSense::info() const {
  SenseInfo info;
  info.source = source_->description();
  info.samples = "pairs";
  info.tells_force = estimator_ != nullptr;
  info.model.kind = "none";
  if (estimator_) info.model = estimator_->body().info();
  info.reason = estimator_ ? ChooseModel(scene_).reason
                           : "the object is tracked without a model: no force is estimated";
  if (scene_.sense.Find<StereoCameras>()) info.remarks.push_back(InWords(rig_));
  info.remarks.push_back(InWords(*scene_.sense.Find<PointTracking>()));
  info.remarks.push_back(
      fmt::format("the rest shape comes from the first {}: nothing may touch the object until then",
                  eyes_->rest_pictures() == 1 ? "pair of images"
                                              : fmt::format("{} images", eyes_->rest_pictures())));
  if (!estimator_) info.remarks.push_back(info.reason);
  if (estimator_) info.changeable.object = ClassOf(scene_.object.geometry);
  return info;
}

std::vector<StageTimes> PointsSense::Stages() const {
  return {TimesOf(eyes_->stage(), times_.look), TimesOf("checks", times_.checks),
          TimesOf("mechanics", estimator_ ? estimator_->times() : LatencyHistogram{}),
          TimesOf("total", times_.total)};
}

PointsOverlay MakePointsOverlay(const SurfacePointTracker& eyes, const SurfaceObservation& seen,
                                const ContactEstimate& felt) {
  PointsOverlay overlay;
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    const Eigen::Vector2d p_I = eyes.PlaceInPicture(i);
    if (p_I.allFinite()) {
      overlay.seen_I.push_back(p_I);
      continue;
    }
    const bool was_seen = !seen.points[i].p_S.isZero(0);
    const auto last_I = eyes.Project(seen.points[i].p_S);
    if (was_seen && last_I) overlay.lost_I.push_back(*last_I);
  }
  overlay.radius_px = eyes.radius_px();
  overlay.windows = eyes.stage() != "dots";
  overlay.validity = ToString(felt.validity);
  const bool has_place = seen.found && (felt.depth > 0 || !felt.force);
  if (has_place && felt.validity != Validity::kTrackingLost) {
    overlay.place_I = eyes.Project(felt.p_S_contact);
  }
  if (!felt.force) return overlay;
  overlay.force = felt.force->norm();
  overlay.sigma = felt.sigma;
  if (!(*overlay.force > 0) || !overlay.place_I) return overlay;
  const auto ahead = eyes.Project(felt.p_S_contact + kShortStep * felt.force->normalized());
  const auto aside = eyes.Project(felt.p_S_contact + kShortStep * felt.force->unitOrthogonal());
  if (!ahead || !aside) return overlay;
  // As long as the same force would be drawn across the line of sight, foreshortened.
  const double full_length = (*aside - *overlay.place_I).norm();
  if (full_length > 0) overlay.along_I = (*ahead - *overlay.place_I) / full_length;
  return overlay;
}

cv::Mat AsPicture(const cv::Mat& image) {
  if (image.depth() != CV_16U) return image;
  cv::Mat grey;
  cv::normalize(image, grey, 0, 255, cv::NORM_MINMAX, CV_8U, image > 0);
  return grey;
}

cv::Mat DrawPoints(const cv::Mat& image, const PointsOverlay& overlay, double full_scale) {
  cv::Mat picture;
  cv::cvtColor(AsPicture(image), picture, cv::COLOR_GRAY2BGR);
  const int radius = std::max(2, static_cast<int>(std::lround(overlay.radius_px)));
  for (const Eigen::Vector2d& p : overlay.seen_I) {
    const cv::Point centre = Round(p);
    if (overlay.windows) {
      cv::rectangle(picture, centre - cv::Point(radius, radius), centre + cv::Point(radius, radius),
                    kSeenColour, 1);
    } else {
      cv::circle(picture, centre, radius + 2, kSeenColour, 1, cv::LINE_AA);
    }
    cv::drawMarker(picture, centre, kSeenColour, cv::MARKER_CROSS, 5, 1);
  }
  for (const Eigen::Vector2d& p : overlay.lost_I) {
    cv::drawMarker(picture, Round(p), kLostColour, cv::MARKER_TILTED_CROSS, 2 * radius, 1,
                   cv::LINE_AA);
  }
  if (overlay.place_I) {
    const double share = ShareOf(overlay, full_scale);
    const Eigen::Vector2d force_I = 0.2 * image.rows * share * overlay.along_I;
    const cv::Point place = Round(*overlay.place_I);
    cv::drawMarker(picture, place, kLoadColour, cv::MARKER_CROSS, 21, 2, cv::LINE_AA);
    const int ring = static_cast<int>(std::lround(kRing * image.rows * share));
    if (ring > 1) cv::circle(picture, place, ring, kLoadColour, 2, cv::LINE_AA);
    if (force_I.norm() > 3) {
      cv::arrowedLine(picture, place, Round(*overlay.place_I + force_I), kLoadColour, 2,
                      cv::LINE_AA, 0, 0.2);
    }
  }
  DrawWords(ForceInWords(overlay), kLoadColour, &picture);
  return picture;
}

}  // namespace palpate
