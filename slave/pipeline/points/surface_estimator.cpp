#include "slave/pipeline/points/surface_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "slave/checks/load/encoder_depth.h"
#include "slave/pipeline/base/estimate_builder.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/local_model/patch_maker.h"
#include "slave/pipeline/local_model/stiffness_scale.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Range of the model relative to the larger side, if it states none [-].
constexpr double kDefaultRange = 0.5;
// Spread of the ratio of estimated to modelled force before a contact [-]. [derived: at equal depth
// the plate's force is high by up to 13 %, see PlateLoadIdentifier]
constexpr double kSurfaceSpread = 0.1;
// Time in which the ratio is learnt [s]. [tuned: TheRenderedForceNeverJumps]
constexpr double kSurfaceLearningTime = 0.1;
// Distance from the edge at which a tip counts as beside the surface, relative to the larger side
// [-]. [tuned: surface_contact_test]
constexpr double kBesideEdge = 1e-3;

}  // namespace

SurfaceEstimator::SurfaceEstimator(const Scene& scene)
    : X_SO_(scene.object.X_SO),
      X_OS_(X_SO_.inverse()),
      full_depth_(scene.operator_options.press_depth),
      min_informative_depth_(kInformativeDepth * scene.operator_options.press_depth),
      stiffness_scale_(scene.operator_options.press_depth,
                       LearningRate(kSurfaceLearningTime, SensorRate(scene.sense)),
                       kSurfaceSpread) {
  Adopt(MakeLoadIdentifier(scene), scene);
}

void SurfaceEstimator::Adopt(std::unique_ptr<LoadIdentifier> body, const Scene& scene) {
  if (body_) body->TakeOver(body_.get());
  body_ = std::move(body);
  builder_.Adopt(scene);
  const double range = body_->info().range;
  tool_width_ = scene.tool ? scene.tool->width : 0;
  larger_side_ = LargerSide(body_->surface().nodes);
  valid_radius_ = (range > 0 ? range : kDefaultRange) * larger_side_;
  stiffness_scale_.Forget();
}

void SurfaceEstimator::Reset() noexcept {
  body_->Reset();
  load_ = {};
  stiffness_scale_.Forget();
  builder_.Reset();
  checks_.Reset();
}

const ContactEstimate& SurfaceEstimator::Estimate(const SurfaceObservation& seen,
                                                  const Vector3d& p_S_tip,
                                                  std::optional<double> arm_lag) noexcept {
  estimate_.sample = seen.sequence;
  estimate_.sensed_at = seen.sensed_at;
  estimate_.events.Clear();
  if (p_S_tip.allFinite()) estimate_.p_S_tip = p_S_tip;
  builder_.Track(seen.found, &estimate_);
  estimate_.details = {};
  if (seen.epipolar_px > 0) estimate_.details.epipolar = seen.epipolar_px;
  if (seen.found) {
    Stopwatch lap;
    ToObject(seen.points);
    load_ = body_->Fit(points_O_);
    estimate_.details.misfit = load_.residual;
    LoadSample sample{.seen = seen, .load = load_, .size = larger_side_};
    if (arm_lag && p_S_tip.allFinite()) sample.tool = ToolAt(p_S_tip, *arm_lag);
    load_.Take(checks_.Examine(sample));
    load_.Add(seen);
    times_.Add(lap.Lap());
    SetEstimate(arm_lag.has_value());
    Learn();
  } else {
    Lose({Validity::kTrackingLost, seen.check, seen.reason});
  }
  estimate_.local_model = LocalAt(estimate_.p_S_tip);
  return estimate_;
}

void SurfaceEstimator::ToObject(const std::vector<SurfacePoint>& points_S) {
  const Matrix3d R_OS = X_OS_.linear();
  points_O_ = points_S;
  for (SurfacePoint& point : points_O_) {
    point.p_S_rest = X_OS_ * point.p_S_rest;
    point.p_S = X_OS_ * point.p_S;
    point.covariance = R_OS * point.covariance * R_OS.transpose();
  }
}

// Converts the load to the slave's convention: the force of the object on the tool, frame S.
void SurfaceEstimator::SetEstimate(bool shows_tool) noexcept {
  if (!IsForceKnown(load_.validity)) return Lose(load_);
  const bool pressed = load_.force != 0;
  builder_.Touch(pressed, &estimate_);
  Vector3d p_O = load_.p_O, n_O = load_.n_O;
  if (!pressed) body_->Nearest(X_OS_ * estimate_.p_S_tip, &p_O, &n_O);
  estimate_.p_S_contact = X_SO_ * p_O;
  estimate_.depth = std::max(0.0, load_.depth);
  builder_.SetForce(-load_.force * (X_SO_.linear() * n_O), load_.sigma_force, load_, &estimate_);
  SetMoment(shows_tool);
}

// The load is uniform over the tool's patch, so its force acts at the centre, which the points
// determine. A load that is not at the tip gives no information on the tool.
void SurfaceEstimator::SetMoment(bool shows_tool) noexcept {
  estimate_.moment.reset();
  if (!shows_tool || tool_width_ == 0) return;
  std::optional<Vector3d> moment;
  const Vector3d arm = estimate_.p_S_contact - estimate_.p_S_tip;
  if (estimate_.force && arm.norm() < EncoderDepthCheck::kNear * larger_side_) {
    moment = arm.cross(*estimate_.force);
  }
  builder_.SetMoment(moment, std::abs(load_.force) * load_.sigma_place, tool_width_ / 2,
                     &estimate_);
}

void SurfaceEstimator::Lose(const Verdict& verdict) noexcept {
  EstimateBuilder::LoseForce(verdict, &estimate_);
  last_depth_ = std::numeric_limits<double>::quiet_NaN();
}

ToolReading SurfaceEstimator::ToolAt(const Vector3d& p_S_tip, double lag) noexcept {
  ToolReading tool{.lag = lag};
  const Vector3d p_O_tip = X_OS_ * p_S_tip;
  Vector3d n_O;
  body_->Nearest(p_O_tip, &tool.p_O, &n_O);
  tool.depth = std::max(0.0, n_O.dot(tool.p_O - p_O_tip));
  tool.stiffness = body_->PressAt(tool.p_O, std::max(tool.depth, load_.depth)).stiffness;
  return tool;
}

// Compares the load found from the points with the force computed from the tip's depth alone. The
// depth belongs to another time than the image, so the motion since the last image is an error.
void SurfaceEstimator::Learn() noexcept {
  const Vector3d p_O_tip = X_OS_ * estimate_.p_S_tip;
  Vector3d p_O, n_O;
  body_->Nearest(p_O_tip, &p_O, &n_O);
  const double depth = n_O.dot(p_O - p_O_tip);
  const double moved = std::abs(depth - std::exchange(last_depth_, depth));
  const bool is_the_tips = (load_.p_O - p_O).norm() < EncoderDepthCheck::kNear * larger_side_;
  if (estimate_.validity != Validity::kValid || !is_the_tips || !(depth > min_informative_depth_))
    return;
  const LoadIdentifier::Press press = body_->PressAt(p_O, depth);
  if (!press.valid) return;
  const double sigma = std::hypot(load_.sigma_force, press.stiffness * moved);
  stiffness_scale_.Learn(depth, CompareForces(-load_.force, sigma, press.force));
}

// f(p) = F_r n + k n n^T (reference - p) has the correct force and slope at the present depth d
// with F_r = F - k d. F_r is negative for a stiffening membrane, whose tangent reaches zero below
// the surface.
LocalModel SurfaceEstimator::LocalAt(const Vector3d& p_S_tip) noexcept {
  if (!p_S_tip.allFinite()) return local_;
  const Vector3d p_O_tip = X_OS_ * p_S_tip;
  Vector3d p_O, n_O;
  body_->Nearest(p_O_tip, &p_O, &n_O);
  double depth = n_O.dot(p_O - p_O_tip);
  const LoadIdentifier::Press modelled = body_->PressAt(p_O, std::max(0.0, depth));
  auto press = stiffness_scale_.Scaled({modelled.force, modelled.stiffness}, std::max(0.0, depth));
  const bool usable =
      std::isfinite(press.force) && std::isfinite(press.stiffness) && press.stiffness > 0;
  if (!usable) return local_;
  // The plane extends beyond the edge of the surface, where there is no contact.
  const double beside = (p_O_tip - p_O + depth * n_O).norm();
  if (beside > kBesideEdge * larger_side_) depth = press.stiffness = 0;
  LocalModel next;
  next.normal = X_SO_.linear() * n_O;
  next.reference = X_SO_ * p_O;
  if (depth > 0) next.force = (press.force - press.stiffness * depth) * next.normal;
  next.stiffness = press.stiffness * next.normal * next.normal.transpose();
  next.valid_radius = valid_radius_;
  next.in_contact = depth > 0;
  local_ = Revised(next, local_);
  return local_;
}

bool SurfaceEstimator::MakePatch(const Vector3d& p_S_tip, SurfacePatch* patch) noexcept {
  if (!p_S_tip.allFinite()) return false;
  const auto stiffness = [this](const Vector3d& p_O, int, const Vector3d& n_S) -> Matrix3d {
    const LoadIdentifier::Press press = body_->PressAt(p_O, 0);
    const double k = press.valid ? press.stiffness : 0.0;
    return k * n_S * n_S.transpose();
  };
  if (!FillPatch(body_->surface(), X_OS_ * p_S_tip, X_SO_, /*frictionless=*/true, stiffness,
                 patch)) {
    return false;
  }
  patch->full_depth = full_depth_;
  patch->valid_depth = valid_radius_;
  return true;
}

void SurfaceEstimator::LearnLaw(PatchLaw* law) noexcept {
  Vector3d p_O, n_O;
  body_->Nearest(X_OS_ * estimate_.p_S_tip, &p_O, &n_O);
  const LoadIdentifier::Press begins = body_->PressAt(p_O, 0);
  if (!begins.valid || !(begins.stiffness > 0)) return;
  for (int i = 1; i < kLawPoints; ++i) {
    const double depth = full_depth_ * i / (kLawPoints - 1);
    const LoadIdentifier::Press press = body_->PressAt(p_O, depth);
    const double force = stiffness_scale_.Scaled({press.force, press.stiffness}, depth).force;
    if (!press.valid || !(force >= 0)) return;
    law->ratios[static_cast<std::size_t>(i)] = force / (begins.stiffness * depth);
  }
  law->ratios[0] = stiffness_scale_.At(0).ratio;
}

void SurfaceEstimator::DeformedNodes(std::vector<Vector3d>* p_S) {
  body_->Displacements(p_S);
  const std::vector<Vector3d>& rest = body_->surface().nodes;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    (*p_S)[i] = X_SO_ * Vector3d(rest[i] + (*p_S)[i]);
  }
}

void SurfaceEstimator::NodalForces(std::vector<Vector3d>* f_S) {
  body_->NodalForces(f_S);
  for (Vector3d& force : *f_S) force = X_SO_.linear() * force;
}

void RigidTranslation::Start(const SurfaceObservation& seen) noexcept {
  first_.assign(seen.points.size(), 0);
  p_S_rest_.setZero();
  int count = 0;
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    if (!seen.points[i].seen) continue;
    first_[i] = 1;
    p_S_rest_ += seen.points[i].p_S_rest;
    ++count;
  }
  if (count > 0) p_S_rest_ /= count;
}

const ContactEstimate& RigidTranslation::Estimate(const SurfaceObservation& seen) noexcept {
  estimate_.sample = seen.sequence;
  estimate_.sensed_at = seen.sensed_at;
  estimate_.events.Clear();
  if (first_.size() != seen.points.size() && seen.found) Start(seen);
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  int count = 0;
  for (std::size_t i = 0; seen.found && i < seen.points.size(); ++i) {
    const SurfacePoint& point = seen.points[i];
    if (!point.seen || !first_[i] || !point.p_S.allFinite()) continue;
    moved += point.p_S - point.p_S_rest;
    ++count;
  }
  if (count > 0) {
    moved_ = moved / count;
    estimate_.p_S_tip = estimate_.p_S_contact = p_S_rest_ + moved_;
  }
  const Validity validity = count > 0 ? Validity::kFailed : Validity::kTrackingLost;
  if (validity != estimate_.validity) {
    estimate_.events.Add(count > 0 ? Event::kTrackingRegained : Event::kTrackingLost);
  }
  estimate_.Set({validity, seen.check, seen.reason});
  return estimate_;
}

}  // namespace palpate
