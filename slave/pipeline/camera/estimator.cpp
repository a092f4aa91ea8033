#include "slave/pipeline/camera/estimator.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "slave/mechanics/make_model.h"
#include "slave/pipeline/sense.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/contour_registration.h"

namespace palpate {
namespace {

std::optional<Eigen::Vector2d> ToImage(const CameraView& view,
                                       const std::optional<Eigen::Vector3d>& p_S) {
  if (!p_S) return std::nullopt;
  return view.ToImage(*p_S);
}

// A loop seen in S as an outline in O.
Outline ToOutline(const std::vector<Eigen::Vector2d>& loop_S, const Eigen::Isometry3d& X_SO) {
  const Eigen::Isometry3d X_OS = X_SO.inverse();
  Outline outline;
  for (const Eigen::Vector2d& p : loop_S) {
    outline.outer.emplace_back((X_OS * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>());
  }
  return outline;
}

Eigen::Vector3d Planar(const Eigen::Vector2d& v) {
  return {v.x(), v.y(), 0};
}

}  // namespace

Estimator::Estimator(const Scene& scene, const Frame& first,
                     std::optional<Eigen::Vector3d> p_S_tip_reported)
    : view_(*scene.sense.Find<Camera>(), first.image.cols, first.image.rows),
      eyes_(std::make_unique<TipAndContourTracker>(scene, first.image,
                                                   ToImage(view_, p_S_tip_reported))),
      tool_width_(scene.tool->width) {
  RegisterObject(scene);
  Adopt(Prepare(scene), scene);
  observation_ = &eyes_->Look(first.image, first.sequence, first.sensed_at);
}

Estimator::~Estimator() = default;

void Estimator::RegisterObject(const Scene& scene) {
  registration_.X_SO = scene.object.X_SO;
  const std::vector<Eigen::Vector2d>& contour_I = eyes_->rest_contour_I();
  if (std::holds_alternative<ImageContourGeometry>(scene.object.geometry)) {
    const Curve smooth_I = Smoothed(contour_I, scene.sense.Find<ContourTracking>()->control_points);
    const std::vector<Eigen::Vector2d> loop_S = ToSlave(smooth_I, view_);
    // Frame O sits in the middle of what was found, so that `fixed: arc` means an arc of it.
    registration_.X_SO.translation().head<2>() = Centroid(loop_S);
    seen_ = ToOutline(loop_S, registration_.X_SO);
    registration_.measured = true;
    registration_.points = static_cast<int>(contour_I.size());
    return;
  }
  if (contour_I.empty()) return;
  const OutlineFit fit =
      FitOutline(OutlineOf(scene.object.geometry), registration_.X_SO, contour_I, view_);
  if (!fit.found) {
    throw std::runtime_error(fmt::format(
        "{}: object.geometry: the outline seen in the first picture does not fit it ({} of {} "
        "contour points agree): check object.pose, camera.pixel and sense.contour.start",
        scene.file.string(), fit.inliers, contour_I.size()));
  }
  registration_ = {true, fit.X_SO, fit.rms_px, fit.inliers};
  rest_sigma_ = fit.rms_px * view_.pixel() / std::sqrt(static_cast<double>(fit.inliers));
}

std::unique_ptr<TouchModel> Estimator::Prepare(const Scene& scene) const {
  auto touch = std::make_unique<TouchModel>();
  touch->mesh = MeshOutline(scene, seen_);
  touch->deformation = MakeModel(scene, touch->mesh);
  touch->contact = std::make_unique<BoundaryContact>(touch->mesh);
  touch->probe = std::make_unique<BoundaryContact>(touch->mesh);
  return touch;
}

void Estimator::Adopt(std::unique_ptr<TouchModel> touch, const Scene& scene) {
  touch_ = std::move(touch);
  if (rules_.in_contact()) ResumeContact();
  rules_.Adopt(scene);
  law_ = scene.model.contact;
}

void Estimator::ResumeContact() noexcept {
  constexpr double kAbove = 1e-6;  // of the body's size: enough to come in again through the place
  const Eigen::Isometry3d X_OS = registration_.X_SO.inverse();
  const Eigen::Vector3d p_O = X_OS * felt_.p_S_contact;
  const Eigen::Vector3d n_O = X_OS.linear() * felt_.local_model.normal;
  touch_->contact->MoveTip((p_O + kAbove * touch_->mesh.length_unit * n_O).head<2>());
  touch_->contact->MoveTip((X_OS * felt_.p_S_tip).head<2>());
}

void Estimator::Reset() noexcept {
  eyes_->Reset();
  touch_->contact->Reset();
  rules_.Reset();
}

const ContactEstimate& Estimator::Feel(const Frame& frame) noexcept {
  Stopwatch total, lap;
  felt_.sample = frame.sequence;
  felt_.sensed_at = frame.sensed_at;
  felt_.events.Clear();
  observation_ = &eyes_->Look(frame.image, frame.sequence, frame.sensed_at);
  times_.vision.Add(lap.Lap());

  const TipObservation& tip = observation_->tip;
  felt_.details.score = tip.found ? std::optional(tip.score) : std::nullopt;
  if (registration_.measured) felt_.details.registration = registration_.rms_px;
  rules_.Track(tip.found, &felt_);
  if (tip.found) {
    Touch(view_.ToSlave(tip.p_I), tip.sigma * view_.pixel());
  } else {
    EstimateRules::LoseForce(Validity::kTrackingLost, FailedCheck::kTip, &felt_);
  }
  times_.total.Add(total.Lap());
  return felt_;
}

void Estimator::Touch(const Eigen::Vector3d& p_S_tip, double tip_sigma) noexcept {
  Stopwatch lap;
  const Eigen::Isometry3d& X_SO = registration_.X_SO;
  const Eigen::Vector3d p_O_tip = X_SO.inverse() * p_S_tip;
  const BoundaryPlace& place = touch_->contact->MoveTip(p_O_tip.head<2>());
  const bool touching = touch_->contact->in_contact();
  times_.contact.Add(lap.Lap());

  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  if (touching) {
    displacement.head<2>() = p_O_tip.head<2>() - place.p_O;
    const Eigen::Vector3d n = Planar(place.normal_O);
    if (law_ == ContactLaw::kFrictionless) displacement = n.dot(displacement) * n;
  }
  const ContactResponse response = Respond(place, displacement);
  times_.mechanics.Add(lap.Lap());

  felt_.p_S_tip = p_S_tip;
  felt_.p_S_contact = X_SO * Planar(place.p_O);
  felt_.depth = touching ? std::max(0.0, -place.gap) : 0.0;
  rules_.Touch(touching, &felt_);
  if (response.validity == Validity::kFailed || !response.force_O.allFinite()) {
    return EstimateRules::LoseForce(Validity::kFailed, FailedCheck::kNone, &felt_);
  }
  UpdateLocalModel(place, response);
  if (!touching) return rules_.TellForce(Eigen::Vector3d::Zero(), 0, Validity::kValid, &felt_);
  // The force changes most with the tip's place along the normal.
  const double stiffness = (response.stiffness_O * Planar(place.normal_O)).norm();
  rules_.TellForce(-(X_SO.linear() * response.force_O),
                   stiffness * std::hypot(tip_sigma, rest_sigma_), response.validity, &felt_);
}

ContactResponse Estimator::Respond(const BoundaryPlace& place,
                                   const Eigen::Vector3d& displacement_O) noexcept {
  const Contact contact{Contact::Kind::kDisplacement, Planar(place.p_O), place.element, tool_width_,
                        displacement_O};
  ContactResponse response;
  touch_->deformation->Respond(std::span(&contact, 1), std::span(&response, 1));
  return response;
}

LocalModel Estimator::LocalAt(const Eigen::Vector3d& p_S_tip) noexcept {
  if (rules_.in_contact() || !p_S_tip.allFinite()) return felt_.local_model;
  const Eigen::Vector3d p_O_tip = registration_.X_SO.inverse() * p_S_tip;
  touch_->probe->Reset();
  const BoundaryPlace& place = touch_->probe->MoveTip(p_O_tip.head<2>());
  if (touch_->probe->in_contact()) return felt_.local_model;
  // Nothing is pressed in, so that the shape stays that at rest.
  const ContactResponse response = Respond(place, Eigen::Vector3d::Zero());
  if (response.validity != Validity::kFailed) UpdateLocalModel(place, response);
  return felt_.local_model;
}

void Estimator::UpdateLocalModel(const BoundaryPlace& place,
                                 const ContactResponse& response) noexcept {
  const Eigen::Matrix3d& R = registration_.X_SO.linear();
  LocalModel next;
  next.reference = registration_.X_SO * Planar(place.p_O);
  next.normal = R * Planar(place.normal_O);
  // A passive contact has a symmetric stiffness; collocation leaves a small skew part, which would
  // create energy in the operator's hand.
  const Eigen::Matrix3d K_O = 0.5 * (response.stiffness_O + response.stiffness_O.transpose());
  next.stiffness = R * K_O * R.transpose();
  next.valid_radius = touch_->deformation->info().range * touch_->mesh.length_unit;
  next.in_contact = rules_.in_contact();
  felt_.local_model = Revised(next, felt_.local_model);
}

}  // namespace palpate
