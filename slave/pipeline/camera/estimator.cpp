#include "slave/pipeline/camera/estimator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slave/checks/camera/image_quality.h"
#include "slave/pipeline/local_model/patch_maker.h"

namespace palpate {
namespace {

constexpr double kFarSigmas = 3;     // above the surface, a tip surely touches nothing
constexpr double kDentStands = 0.7;  // part of a dent that needs no second look
constexpr double kBlurMoves = 1;     // sigma of the tip where no edge is left [px]
// Where the tip's sigma is more, its dent tells: known to this part of the tool's width, and not
// farther from the tip seen [px].
constexpr double kDentTells = 0.1, kDentFar = 6;

std::optional<Eigen::Vector2d> ToImage(const CameraView& view,
                                       const std::optional<Eigen::Vector3d>& p_S) {
  if (!p_S) return std::nullopt;
  return view.ToImage(*p_S);
}

// Depth that a tip has, rms, which is seen `gap` above the surface by eyes of that sigma [m]: the
// part of a normal distribution below the surface.
double HiddenDepth(double gap, double sigma) {
  const double z = sigma > 0 ? gap / sigma : kFarSigmas;
  if (!(z < kFarSigmas)) return 0;
  const double below = std::erfc(z / std::numbers::sqrt2) / 2;
  const double density = std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
  return sigma * std::sqrt(std::max(0.0, (1 + z * z) * below - z * density));
}

// The measurements of the object's edge; `seen` is null where the scene tracks no contour.
void ReportSighting(const ObjectSighting* seen, CheckDetails* details) {
  details->contour = details->camera_motion = std::nullopt;
  if (seen == nullptr || !seen->known) return;
  details->contour = seen->residual_px;
  details->camera_motion = seen->motion.shift.norm();
}

}  // namespace

Estimator::Estimator(const Scene& scene, const Frame& first,
                     std::optional<Eigen::Vector3d> p_S_tip_reported)
    : view_(*scene.sense.Find<Camera>(), first.image.cols, first.image.rows),
      tracker_(std::make_unique<TipAndContourTracker>(scene, first.image,
                                                      ToImage(view_, p_S_tip_reported))) {
  registration_ = RegisterObject(scene, tracker_->rest_contour().edge, view_);
  Adopt(Prepare(scene), scene);
  if (!tracker_->rest_contour().edge.empty()) {
    watch_.emplace(first.image, tracker_->rest_contour().edge, view_, registration_.X_SO,
                   touch_->mesh);
  }
  tool_.d_I = tracker_->tool_direction_I();
  tool_.width = scene.tool->width / view_.pixel();
  checks_ = MakeCameraChecks(scene, {first.image, tracker_->noise(), tool_.d_I, tool_.width,
                                     ToImage(view_, p_S_tip_reported)});
  observation_ = &tracker_->Process(first.image, first.sequence, first.sensed_at);
}

Estimator::~Estimator() = default;

std::unique_ptr<TouchModel> Estimator::Prepare(const Scene& scene, Progress* progress) const {
  return std::make_unique<TouchModel>(scene, registration_.seen, progress);
}

void Estimator::Adopt(std::unique_ptr<TouchModel> touch, const Scene& scene) {
  touch_ = std::move(touch);
  rules_.Adopt(scene);
  cue_.Adopt(scene.model.puncture_from);
  dent_.Adopt();
  pressed_place_ = {};
  if (watch_) watch_->Adopt(touch_->mesh);
  if (rules_.in_contact()) ResumeContact();
}

void Estimator::ResumeContact() noexcept {
  constexpr double kAbove = 1e-6;  // of the body's size: enough to come in again through the place
  const Eigen::Isometry3d X_OS = registration_.X_SO.inverse();
  const Eigen::Vector3d p_O = X_OS * felt_.p_S_contact;
  const Eigen::Vector3d n_O = X_OS.linear() * felt_.local_model.normal;
  touch_->contact->MoveTip((p_O + kAbove * touch_->mesh.length_unit * n_O).head<2>());
  ExpectDent(touch_->contact->MoveTip((X_OS * felt_.p_S_tip).head<2>()));
}

Eigen::Isometry3d Estimator::ApparentPose() const {
  const Eigen::Isometry3d& X_SO = registration_.X_SO;
  if (!watch_) return X_SO;
  const PictureMotion& motion = watch_->sighting().motion;
  const auto moved = [&](const Eigen::Vector3d& p_S) -> Eigen::Vector2d {
    return view_.ToSlave(motion.Apply(view_.ToImage(p_S))).head<2>();
  };
  const Eigen::Vector3d x_O(touch_->mesh.length_unit, 0, 0);
  const Eigen::Vector2d origin = moved(X_SO.translation()), x_now = moved(X_SO * x_O) - origin;
  const Eigen::Vector2d x_rest = (X_SO.linear() * x_O).head<2>();
  const double turn = std::atan2(x_now.y(), x_now.x()) - std::atan2(x_rest.y(), x_rest.x());
  Eigen::Isometry3d apparent = X_SO;
  apparent.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * X_SO.linear();
  apparent.translation().head<2>() = origin;
  return apparent;
}

void Estimator::Reset() noexcept {
  tracker_->Reset();
  touch_->contact->Reset();
  rules_.Reset();
  cue_.Reset();
  if (watch_) watch_->Reset();
  checks_.Reset();
  agreement_.Reset();
}

void Estimator::Look(const Frame& frame) noexcept {
  Stopwatch lap;
  observation_ = &tracker_->Process(frame.image, frame.sequence, frame.sensed_at);
  looked_at_ = frame.sequence;
  look_us_ = lap.Lap();
}

const ContactEstimate& Estimator::Estimate(const Frame& frame,
                                           const std::optional<EncoderReading>& said) noexcept {
  Stopwatch total, lap;
  felt_.sample = frame.sequence;
  felt_.sensed_at = frame.sensed_at;
  felt_.events.Clear();
  const double looked_us = looked_at_ == frame.sequence ? look_us_ : 0;
  if (looked_at_ != frame.sequence) Look(frame);
  looked_at_.reset();
  lap.Lap();
  times_.vision.Add(look_us_);
  shown_window_ = tracker_->search_window();
  shown_tip_ = observation_->tip;
  felt_.processed_at = Clock::now();
  ProcessObject(frame.image);
  checks_us_ = lap.Lap();

  const TipObservation& tip = observation_->tip;
  felt_.moment.reset();
  felt_.details.score = tip.found ? std::optional(tip.score) : std::nullopt;
  if (registration_.measured) felt_.details.registration = registration_.rms_px;
  ReportSighting(sighting(), &felt_.details);
  rules_.Track(tip.found, &felt_);
  CameraSample sample{
      .image = frame.image, .tip = tip, .object = watch_ ? &watch_->sighting() : nullptr};
  if (tip.found) {
    const Eigen::Vector2d p_I = CompensatedTip(tip);
    CompareWithEncoders(view_.ToSlave(p_I), said);
    sample.agrees_with_encoders = agreement_.agrees();
    sample.is_solved = Touch(view_.ToSlave(p_I));
  } else {
    EstimateBuilder::LoseForce(
        {Validity::kTrackingLost, FailedCheck::kTip, "the tip is not detected"}, &felt_);
  }
  lap.Lap();
  sample.is_broken = rules_.broken();
  sample.dent_O = pressed_by_.head<2>() / view_.pixel();
  sample.dent_sigma = dent_.sigma();
  sample.tip_sigma = tip_sigma_;
  felt_.Add(checks_.Examine(sample).verdict);
  times_.checks.Add(checks_us_ + lap.Lap());
  times_.total.Add(looked_us + total.Lap());
  return felt_;
}

// Where the tip is in the first picture's frame [px], and how well that is known. A tip that is
// only roughly known, under a cover, is told by the dent it makes if that is seen well.
Eigen::Vector2d Estimator::CompensatedTip(const TipObservation& tip) noexcept {
  tip_sigma_ = tip.sigma;
  tip_covariance_ = tip.sigma * tip.sigma * Eigen::Matrix2d::Identity();
  if (!watch_) return tip.p_I;
  const ObjectSighting& object = watch_->sighting();
  // The template stays as large as it was, the tool in a zoomed picture does not.
  const Eigen::Vector2d grown = std::expm1(object.motion.growth) * tip.lever;
  const Eigen::Vector2d p_I = object.motion.Back(tip.p_I + grown);
  const double blurred = std::max(0.0, 1 - object.sharpness);
  tip_sigma_ = std::hypot(tip.sigma, object.sigma_px, kBlurMoves * blurred);
  tip_covariance_.diagonal().array() += kBlurMoves * blurred * kBlurMoves * blurred;
  tip_covariance_ += object.motion_covariance;
  if (tip.sigma < ImageQualityCheck::kRoughTip || !object.dent_known || !rules_.in_contact())
    return p_I;
  if (rules_.broken()) return p_I;
  const double sigma =
      std::hypot(std::sqrt(object.dent_covariance.trace()), dent_.sigma() * object.dent_O.norm());
  const Eigen::Vector2d dent_S = registration_.X_SO.linear().topLeftCorner<2, 2>() * object.dent_O;
  const Eigen::Vector3d p_S = felt_.p_S_contact + view_.pixel() * Planar(dent_S);
  const Eigen::Vector2d by_dent = view_.ToImage(p_S);
  if (!(sigma < kDentTells * tool_.width) || (by_dent - p_I).norm() > kDentFar) return p_I;
  tip_sigma_ = sigma;
  tip_covariance_ = sigma * sigma * Eigen::Matrix2d::Identity();
  return by_dent;
}

// Compares the compensated tip with the encoders. `p_S_tip`: on an object that rests.
void Estimator::CompareWithEncoders(const Eigen::Vector3d& p_S_tip,
                                    const std::optional<EncoderReading>& said) noexcept {
  if (!said) return agreement_.Skip();
  ManipulatorAgreement::Sight sight;
  sight.at = felt_.sensed_at;
  sight.p_S_seen = view_.ToSlave(observation_->tip.p_I);
  sight.p_S_at_rest = p_S_tip;
  sight.sigma = tip_sigma_ * view_.pixel();
  sight.pixel = view_.pixel();
  sight.object_known = watch_ && watch_->sighting().known;
  if (sight.object_known) {
    const ObjectSighting& object = watch_->sighting();
    sight.p_S_on_object = view_.ToSlave(object.motion.Back(observation_->tip.p_I));
    sight.object_sigma = object.sigma_px * view_.pixel();
  }
  agreement_.Update(sight, *said);
}

// What the object's edge tells with the dent that is to be expected where the tip is now.
void Estimator::ProcessObject(const cv::Mat& image) noexcept {
  if (!watch_) return;
  const TipObservation& tip = observation_->tip;
  if (tip.found) tool_.p_I_tip = tip.p_I;
  if (tip.found && dent_.expects()) {
    const Eigen::Vector3d p_S = view_.ToSlave(watch_->sighting().motion.Back(tip.p_I));
    const Eigen::Vector3d way_S = p_S - felt_.p_S_contact;
    const bool touches = rules_.in_contact() || way_S.dot(felt_.local_model.normal) < 0;
    const bool presses = touches && !rules_.broken();
    dent_O_.setZero();
    if (presses) {
      dent_O_ = (registration_.X_SO.linear().transpose() * way_S).head<2>() / view_.pixel();
    }
  }
  watch_->Process(image, tool_, dent_O_);
  // A dent that is gone is out of reach of a look where it should be: whichever look finds more of
  // the edge is right.
  const double expected = DepthOf(dent_O_);
  if (!cue_.IsArmed(expected * view_.pixel())) return;
  const ObjectSighting dented = watch_->sighting();
  const bool stands = dented.known && dented.dent_known;
  if (stands && DepthOf(dented.dent_O) > kDentStands * expected) return;
  const ObjectSighting& flat = watch_->Process(image, tool_, Eigen::Vector2d::Zero());
  const auto found = [](const ObjectSighting& seen) { return seen.known ? seen.agreeing : 0; };
  if (found(flat) <= found(dented)) watch_->Process(image, tool_, dent_O_);
}

// Of a displacement of the pressed patch, along the surface's normal [any length].
double Estimator::DepthOf(const Eigen::Vector2d& dent_O) const noexcept {
  return -dent_O.dot(pressed_place_.normal_O);
}

// `depth` [m]
void Estimator::DetectPuncture(double depth) noexcept {
  if (!watch_ || rules_.broken()) return;
  const ObjectSighting& seen = watch_->sighting();
  const Eigen::Vector2d& n = pressed_place_.normal_O;
  const double sigma = std::sqrt(std::max(0.0, n.dot(seen.dent_covariance * n)));
  const bool broke = cue_.Broke({.depth = depth,
                                 .expected_px = depth / view_.pixel(),
                                 .dent_known = seen.known && seen.dent_known,
                                 .seen_px = DepthOf(seen.dent_O),
                                 .sigma_px = sigma});
  if (broke) rules_.Break();
}

void Estimator::ExpectDent(const BoundaryPlace& place) noexcept {
  if (watch_) dent_.Expect(place, tool_, registration_.X_SO, view_, touch_.get(), &*watch_);
}

// How well it is known how far the tip is from the surface, one standard deviation [m]: across it,
// where the force changes most.
double Estimator::GapSigma(const BoundaryPlace& place) const noexcept {
  const Eigen::Vector3d p_S = registration_.X_SO * Planar(place.p_O);
  const Eigen::Vector3d n_S = registration_.X_SO.linear() * Planar(place.normal_O);
  const Eigen::Vector2d n_I =
      (view_.ToImage(p_S + view_.pixel() * n_S) - view_.ToImage(p_S)).normalized();
  return std::hypot(view_.pixel() * std::sqrt(n_I.dot(tip_covariance_ * n_I)), registration_.sigma,
                    n_S.dot(agreement_.parting()));
}

bool Estimator::Touch(const Eigen::Vector3d& p_S_tip) noexcept {
  Stopwatch lap;
  const Eigen::Isometry3d& X_SO = registration_.X_SO;
  const Eigen::Vector3d p_O_tip = X_SO.inverse() * p_S_tip;
  const BoundaryPlace& place = touch_->contact->MoveTip(p_O_tip.head<2>());
  const bool touching = touch_->contact->in_contact();
  times_.contact.Add(lap.Lap());
  ExpectDent(place);
  checks_us_ += lap.Lap();

  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  if (touching) {
    displacement.head<2>() = p_O_tip.head<2>() - place.p_O;
    const Eigen::Vector3d n = Planar(place.normal_O);
    if (touch_->law == ContactLaw::kFrictionless) displacement = n.dot(displacement) * n;
  }
  const ContactResponse response = touch_->Press(place, displacement);
  pressed_place_ = place;
  pressed_by_ = displacement;
  times_.mechanics.Add(lap.Lap());

  felt_.p_S_tip = p_S_tip;
  felt_.p_S_contact = X_SO * Planar(place.p_O);
  felt_.depth = touching ? std::max(0.0, -place.gap) : 0.0;
  rules_.Touch(touching, &felt_);
  if (response.validity == Validity::kFailed || !response.force_O.allFinite()) {
    EstimateBuilder::LoseForce({Validity::kFailed, FailedCheck::kNone, "the model has no solution"},
                               &felt_);
    return false;
  }
  UpdateLocalModel(place, response);
  if (!touching) {
    cue_.Reset();
    const double stiffness = (response.stiffness_O * Planar(place.normal_O)).norm();
    const double unseen = HiddenDepth(place.gap, GapSigma(place));
    rules_.SetForce(Eigen::Vector3d::Zero(), stiffness * unseen, {Validity::kValid}, &felt_);
    rules_.SetMoment(std::nullopt, 0, touch_->reach(), &felt_);
    return true;
  }
  DetectPuncture(felt_.depth);
  const double stiffness = (response.stiffness_O * Planar(place.normal_O)).norm();
  rules_.SetForce(-(X_SO.linear() * response.force_O),
                  std::hypot(stiffness * GapSigma(place),
                             touch_->WidthAt(place).sigma * response.force_O.norm()),
                  {response.validity, FailedCheck::kNone, response.doubt}, &felt_);
  std::optional<Eigen::Vector3d> moment = response.moment_O;
  if (moment) {
    const Eigen::Vector3d arm = Planar(place.p_O) + displacement - p_O_tip;
    moment = -(X_SO.linear() * (*moment + arm.cross(response.force_O)));
  }
  rules_.SetMoment(moment, response.moment_sigma, touch_->reach(), &felt_);
  return true;
}

LocalModel Estimator::LocalAt(const Eigen::Vector3d& p_S_tip) noexcept {
  if (rules_.in_contact() || !p_S_tip.allFinite()) return felt_.local_model;
  const Eigen::Vector3d p_O_tip = registration_.X_SO.inverse() * p_S_tip;
  touch_->probe->Reset();
  const BoundaryPlace& place = touch_->probe->MoveTip(p_O_tip.head<2>());
  if (touch_->probe->in_contact()) return felt_.local_model;
  const ContactResponse response = touch_->Respond(place, Eigen::Vector3d::Zero());
  if (response.validity != Validity::kFailed) UpdateLocalModel(place, response);
  return felt_.local_model;
}

bool Estimator::MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept {
  // A round tool's contact grows with the depth, which no patch tells: the plane follows it.
  if (!p_S_tip.allFinite() || touch_->indenter) return false;
  touch_->probe->Reset();
  const Eigen::Vector3d p_O_tip = registration_.X_SO.inverse() * p_S_tip;
  const int element = touch_->probe->MoveTip(p_O_tip.head<2>()).element;
  const auto stiffness = [this](const Eigen::Vector3d& p_O, int cell, const Eigen::Vector3d&) {
    BoundaryPlace place;
    place.element = cell;
    place.p_O = p_O.head<2>();
    return StiffnessInSlave(touch_->Respond(place, Eigen::Vector3d::Zero()), registration_.X_SO);
  };
  const bool frictionless = touch_->law == ContactLaw::kFrictionless;
  const bool known =
      FillPatch(touch_->mesh, element, registration_.X_SO, frictionless, stiffness, patch);
  patch->full_depth = patch->valid_depth =
      touch_->deformation->info().range * touch_->mesh.length_unit;
  return known;
}

void Estimator::UpdateLocalModel(const BoundaryPlace& place,
                                 const ContactResponse& response) noexcept {
  const Eigen::Matrix3d& R = registration_.X_SO.linear();
  LocalModel next;
  next.reference = registration_.X_SO * Planar(place.p_O);
  next.normal = R * Planar(place.normal_O);
  next.stiffness =
      touch_->SecantPart(response, place) * StiffnessInSlave(response, registration_.X_SO);
  next.valid_radius = touch_->deformation->info().range * touch_->mesh.length_unit;
  next.in_contact = rules_.in_contact();
  felt_.local_model = Revised(next, felt_.local_model);
}

}  // namespace palpate
