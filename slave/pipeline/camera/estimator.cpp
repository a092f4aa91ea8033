#include "slave/pipeline/camera/estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <Eigen/Geometry>

#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/local_model/patch_maker.h"

namespace palpate {
namespace {

// Gap above which a tip certainly does not touch the surface [sigma]. [by definition]
constexpr double kFarSigmas = 3;
// Observed share of the predicted indentation that excludes a puncture [-]. [tuned:
// PuncturesAreReportedWithinAnImageAndTheForceIsZeroFromThere]
constexpr double kIndentationKept = 0.7;
// Sigma of the tip in an image without any edge [px].
constexpr double kBlurSigma = 1;
// Sigma of the tool's end in a template file [px]. [measured: 23 random set-ups by the page, rms
// 0.11]
constexpr double kAnchorSigma = 0.12;
// An indentation replaces a rough tip if its sigma is below this share of the tool's width [-], and
// it is within this distance of the tip [px].
constexpr double kInformativeIndentation = 0.1, kFarIndentation = 6;

CameraView ToolView(const Scene& scene, const CameraView& view) {
  return view.Behind(scene.tool->BehindFront(ThicknessOf(scene.object.geometry)),
                     scene.sense.Find<Camera>()->distance);
}

std::optional<Eigen::Vector2d> ToImage(const CameraView& view,
                                       const std::optional<Eigen::Vector3d>& p_S) {
  if (!p_S) return std::nullopt;
  return view.ToImage(*p_S);
}

// Depth of a tip measured `gap` above the surface with `sigma`, rms [m]: second moment of the part
// of a normal distribution below the surface.
double HiddenDepth(double gap, double sigma) {
  const double z = sigma > 0 ? gap / sigma : kFarSigmas;
  if (!(z < kFarSigmas)) return 0;
  const double below = std::erfc(z / std::numbers::sqrt2) / 2;
  const double density = std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
  return sigma * std::sqrt(std::max(0.0, (1 + z * z) * below - z * density));
}

// Reports the measurements of the object's edge. `object` is null if the scene tracks no contour.
void ReportSighting(const ObjectSighting* object, CheckDetails* details) {
  details->contour = details->camera_motion = std::nullopt;
  if (object == nullptr || !object->known) return;
  details->contour = object->residual_px;
  details->camera_motion = object->motion.shift.norm();
}

}  // namespace

Estimator::Estimator(const Scene& scene, const Frame& first,
                     std::optional<Eigen::Vector3d> p_S_tip_reported, ObjectPlace place,
                     Progress* progress)
    : view_(*scene.sense.Find<Camera>(), first.image.cols, first.image.rows),
      tool_view_(ToolView(scene, view_)),
      tracker_(std::make_unique<TipAndContourTracker>(scene, first.image,
                                                      ToImage(tool_view_, p_S_tip_reported))) {
  registration_ = RegisterObject(scene, tracker_->rest_contour().edge, view_, place);
  Adopt(Prepare(scene, progress), scene);
  if (!tracker_->rest_contour().edge.empty()) {
    edge_.emplace(first.image, tracker_->rest_contour().edge, view_, registration_.X_SO,
                  touch_->mesh);
  }
  const auto* tip = scene.sense.Find<TipTracking>();
  if (tip != nullptr && !tip->template_file.empty())
    anchor_sigma_ = std::hypot(kAnchorSigma, tip->anchor_tolerance) * tool_view_.pixel();
  tool_.d_I = tracker_->tool_direction_I();
  tool_.width = scene.tool->width / tool_view_.pixel();
  if (touch_->radius() > 0 && tool_.d_I.isZero(0)) {
    throw std::runtime_error(
        "tool.direction is missing: expected [x, y], because the first image does not show where "
        "the round tool points");
  }
  checks_ = MakeCameraChecks(
      scene, {first.image, tracker_->noise(), tool_.d_I, EndSizeOf(*scene.tool, tool_view_.pixel()),
              ToImage(tool_view_, p_S_tip_reported)});
  observation_ = See(first);
}

Estimator::~Estimator() = default;

std::unique_ptr<TouchModel> Estimator::Prepare(const Scene& scene, Progress* progress) const {
  return std::make_unique<TouchModel>(scene, registration_.seen, progress);
}

void Estimator::Adopt(std::unique_ptr<TouchModel> touch, const Scene& scene) {
  touch_ = std::move(touch);
  rules_.Adopt(scene);
  pixel_tolerance_ = scene.sense.Find<Camera>()->pixel_tolerance;
  plane_error_ = touch_->domain.error();
  cue_.Adopt(scene.model.puncture_from);
  forecast_.Adopt();
  if (edge_) edge_->Adopt(touch_->mesh);
  if (rules_.in_contact()) {
    ResumeContact();
  } else {
    press_ = {};
  }
}

void Estimator::ResumeContact() noexcept {
  // Height above the surface, relative to the body's size, from which a contact is begun again at
  // the same point [-]. [by definition]
  constexpr double kAbove = 1e-6;
  const BoundaryPlace& last = press_.place;
  const double above = touch_->radius() + kAbove * touch_->mesh.length_unit;
  touch_->contact->Move(last.p_O + above * last.normal_O);
  press_.place = touch_->contact->Move(press_.tool.centre_O);
  ForecastIndentation(press_.place);
}

std::string_view Estimator::flag_reason() const {
  if (!touch_->domain.flag_reason().empty()) return touch_->domain.flag_reason();
  const bool by_model = estimate_.check == FailedCheck::kModelRange;
  return by_model && estimate_.reason != kBeyondRange ? estimate_.reason : std::string_view();
}

double Estimator::GapAtStart() noexcept {
  const TipObservation& tip = observation_.tip;
  if (!tip.found) return std::numeric_limits<double>::infinity();
  touch_->probe->Reset();
  const double gap = touch_->probe->Move(ToolAt(tool_view_.ToSlave(tip.p_I)).centre_O).gap;
  touch_->probe->Reset();
  return gap;
}

Eigen::Isometry3d Estimator::ApparentPose() const {
  const Eigen::Isometry3d& X_SO = registration_.X_SO;
  if (!edge_) return X_SO;
  const ImageMotion& motion = edge_->sighting().motion;
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
  if (edge_) edge_->Reset();
  checks_.Reset();
  agreement_.Reset();
}

CameraObservation Estimator::See(const Frame& frame) noexcept {
  Stopwatch lap;
  const TipObservation& seen = tracker_->Process(frame.image);
  return {seen, tracker_->search_window(), lap.Lap()};
}

const ContactEstimate& Estimator::Estimate(const Frame& frame, const CameraObservation& observation,
                                           const std::optional<EncoderReading>& encoder) noexcept {
  Stopwatch total, lap;
  observation_ = observation;
  times_.vision.Add(observation.duration_us);
  estimate_.sample = frame.sequence;
  estimate_.sensed_at = frame.sensed_at;
  estimate_.processed_at = Clock::now();
  estimate_.events.Clear();
  estimate_.moment.reset();
  PredictIndentation();
  MeasureEdge(frame.image);
  checks_us_ = lap.Lap();

  const TipObservation& tip = observation.tip;
  estimate_.details.score = tip.found ? std::optional(tip.score) : std::nullopt;
  if (registration_.measured) estimate_.details.registration = registration_.rms_px;
  ReportSighting(sighting(), &estimate_.details);
  rules_.Track(tip.found, &estimate_);
  bool is_solved = false;
  const CompensatedTip compensated = CompensateMotion();
  if (tip.found) {
    CompareWithEncoders(compensated, encoder);
    is_solved = UpdateContact(compensated);
  } else {
    agreement_.Skip();
    EstimateBuilder::LoseForce(
        {Validity::kTrackingLost, FailedCheck::kTip, "the tip is not detected"}, &estimate_);
  }
  Examine(frame.image, compensated.sigma, is_solved);
  times_.total.Add(observation.duration_us + total.Lap());
  return estimate_;
}

// Prediction: indentation of the last contact for the present tip, and the resulting motion of the
// edge.
void Estimator::PredictIndentation() noexcept {
  const TipObservation& tip = observation_.tip;
  if (!edge_ || !tip.found) return;
  tool_.p_I_tip = tip.p_I;
  tool_.d_I = Eigen::Rotation2Dd(tip.turn) * tracker_->tool_direction_I();
  if (!forecast_.expects()) return;
  const ToolPlace tool = ToolAt(tool_view_.ToSlave(edge_->sighting().motion.Back(tip.p_I)));
  const Eigen::Vector2d displacement_O = MotionOf(tool).displacement_O.head<2>();
  BoundaryPlace place = press_.place;
  place.gap = -DepthOf(displacement_O);
  if (place.gap < 0) ForecastIndentation(place);
  const bool touches = rules_.in_contact() || place.gap < 0;
  predicted_O_.setZero();
  if (touches && !rules_.broken()) predicted_O_ = displacement_O / view_.pixel();
}

// Measurement: motion and indentation of the object's edge. A search at the predicted indentation
// does not find an edge without indentation. While a puncture is possible, both are searched, and
// the one with more edge positions is used.
void Estimator::MeasureEdge(const cv::Mat& image) noexcept {
  if (!edge_) return;
  auto match = edge_->Measure(image, tool_, predicted_O_);
  const double depth = DepthOf(predicted_O_);
  const ObjectSighting& indented = match.sighting;
  const bool is_kept = indented.known && indented.indentation_known &&
                       DepthOf(indented.indentation_O) > kIndentationKept * depth;
  if (cue_.IsArmed(depth * view_.pixel()) && !is_kept) {
    const auto flat = edge_->Measure(image, tool_, Eigen::Vector2d::Zero());
    const auto found = [](const ObjectSighting& s) { return s.known ? s.agreeing : 0; };
    if (found(flat.sighting) > found(indented)) match = flat;
  }
  edge_->Accept(match);
}

// Returns the tip without the motion of the image. The inaccurate tip of a covered tool is replaced
// by the observed indentation.
Estimator::CompensatedTip Estimator::CompensateMotion() const noexcept {
  const TipObservation& tip = observation_.tip;
  CompensatedTip compensated{tip.p_I, tip.sigma,
                             tip.sigma * tip.sigma * Eigen::Matrix2d::Identity()};
  if (!edge_) return compensated;
  const ObjectSighting& object = edge_->sighting();
  // In a zoomed image the tool has another size than the template.
  const Eigen::Vector2d grown = std::expm1(object.motion.growth) * tip.lever;
  const double blur = kBlurSigma * std::max(0.0, 1 - object.sharpness);
  compensated.p_I = object.motion.Back(tip.p_I + grown);
  compensated.sigma = std::hypot(tip.sigma, object.sigma_px, blur);
  compensated.covariance += blur * blur * Eigen::Matrix2d::Identity() + object.motion_covariance;
  if (tip.sigma < CameraLimits::kRoughTip) return compensated;
  const auto by_indentation = TipByIndentation();
  if (!by_indentation) return compensated;
  const double apart = (by_indentation->p_I - compensated.p_I).norm();
  return apart > kFarIndentation ? compensated : *by_indentation;
}

std::optional<Estimator::CompensatedTip> Estimator::TipByIndentation() const noexcept {
  const ObjectSighting& object = edge_->sighting();
  if (!object.indentation_known || !rules_.in_contact() || rules_.broken()) return std::nullopt;
  const double sigma = std::hypot(std::sqrt(object.indentation_covariance.trace()),
                                  forecast_.sigma() * object.indentation_O.norm());
  if (!(sigma < kInformativeIndentation * tool_.width)) return std::nullopt;
  const Eigen::Vector2d p_O =
      TipOf(press_.place, press_.tool.d_O, view_.pixel() * object.indentation_O);
  const Eigen::Vector3d p_S = registration_.X_SO * Planar(p_O);
  return CompensatedTip{tool_view_.ToImage(p_S), sigma,
                        sigma * sigma * Eigen::Matrix2d::Identity()};
}

void Estimator::CompareWithEncoders(const CompensatedTip& tip,
                                    const std::optional<EncoderReading>& encoder) noexcept {
  const Eigen::Vector2d& p_I = observation_.tip.p_I;
  ManipulatorAgreement::Sight sight;
  sight.at = estimate_.sensed_at;
  sight.p_S_seen = tool_view_.ToSlave(p_I);
  sight.p_S_at_rest = tool_view_.ToSlave(tip.p_I);
  sight.sigma = tip.sigma * tool_view_.pixel();
  sight.pixel = tool_view_.pixel();
  sight.object_known = edge_ && edge_->sighting().known;
  if (sight.object_known) {
    const ObjectSighting& object = edge_->sighting();
    sight.p_S_on_object = tool_view_.ToSlave(object.motion.Back(p_I));
    sight.object_sigma = object.sigma_px * tool_view_.pixel();
  }
  if (encoder) {
    agreement_.Update(sight, *encoder);
  } else {
    agreement_.Skip(sight);
  }
}

std::optional<EncoderInnovation> Estimator::Innovation() const noexcept {
  if (!agreement_.has_reading()) return std::nullopt;
  const EncoderRegistration& registration = agreement_.registration();
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  return EncoderInnovation{
      tool_view_.ToImage(registration.innovation()) - tool_view_.ToImage(origin),
      registration.sigma() / tool_view_.pixel()};
}

// Returns the component along the surface's normal, into the object [unit of `indentation_O`].
double Estimator::DepthOf(const Eigen::Vector2d& indentation_O) const noexcept {
  return -indentation_O.dot(press_.place.normal_O);
}

// `depth` [m]
void Estimator::DetectPuncture(double depth) noexcept {
  if (!edge_ || rules_.broken()) return;
  const ObjectSighting& object = edge_->sighting();
  const Eigen::Vector2d& n = press_.place.normal_O;
  const double sigma = std::sqrt(std::max(0.0, n.dot(object.indentation_covariance * n)));
  const bool broke = cue_.Broke({.depth = depth,
                                 .expected_px = depth / view_.pixel(),
                                 .indentation_known = object.known && object.indentation_known,
                                 .seen_px = DepthOf(object.indentation_O),
                                 .sigma_px = sigma});
  if (broke) rules_.Break();
}

void Estimator::ForecastIndentation(const BoundaryPlace& place) noexcept {
  if (edge_) forecast_.Expect(place, tool_, registration_.X_SO, view_, touch_.get(), &*edge_);
}

// Returns the sigma of the tip's distance from the surface along the normal [m].
double Estimator::GapSigma(const BoundaryPlace& place,
                           const Eigen::Matrix2d& covariance) const noexcept {
  const Eigen::Vector3d p_S = registration_.X_SO * Planar(place.p_O);
  const Eigen::Vector3d n_S = registration_.X_SO.linear() * Planar(place.normal_O);
  const Eigen::Vector2d n_I =
      (tool_view_.ToImage(p_S + tool_view_.pixel() * n_S) - tool_view_.ToImage(p_S)).normalized();
  const double tip_sigma =
      std::hypot(tool_view_.pixel() * std::sqrt(n_I.dot(covariance * n_I)), anchor_sigma_);
  return std::hypot(tip_sigma, registration_.sigma, n_S.dot(agreement_.Unexplained()));
}

// Returns the position of the tool with its apex at `p_S_tip` and the direction of the last image.
Estimator::ToolPlace Estimator::ToolAt(const Eigen::Vector3d& p_S_tip) const noexcept {
  const Eigen::Vector2d d_I =
      Eigen::Rotation2Dd(observation_.tip.turn) * tracker_->tool_direction_I();
  const Eigen::Isometry3d X_OS = registration_.X_SO.inverse();
  const Eigen::Vector3d way_S = tool_view_.ToSlave(d_I) - tool_view_.ToSlave({0, 0});
  const Eigen::Vector2d d_O = (X_OS.linear() * way_S).head<2>() / tool_view_.pixel();
  return {(X_OS * p_S_tip).head<2>() - touch_->radius() * d_O, d_O};
}

// Returns the distance across the normal from the point below the centre of a round end to the one
// that touched first, if the tool points along `d_O`.
Eigen::Vector2d Estimator::RolledBy(const Eigen::Vector2d& normal_O,
                                    const Eigen::Vector2d& d_O) const noexcept {
  const Eigen::Vector2d& before = press_.d_O;
  const double sine = before.x() * d_O.y() - before.y() * d_O.x();
  return -touch_->radius() * sine * Eigen::Vector2d(-normal_O.y(), normal_O.x());
}

// Returns the apex of a tool that points along `d_O` and has displaced the place by
// `displacement_O` [m].
Eigen::Vector2d Estimator::TipOf(const BoundaryPlace& place, const Eigen::Vector2d& d_O,
                                 const Eigen::Vector2d& displacement_O) const noexcept {
  const Eigen::Vector2d& n = place.normal_O;
  return place.p_O + displacement_O - RolledBy(n, d_O) + touch_->radius() * (n + d_O);
}

// Returns the motion of the tool since it touched at the place of the last contact.
TouchModel::ToolMotion Estimator::MotionOf(const ToolPlace& tool) const noexcept {
  const Eigen::Vector2d& n = press_.place.normal_O;
  const Eigen::Vector2d rolled_O = RolledBy(n, tool.d_O);
  const Eigen::Vector2d displacement_O =
      tool.centre_O - press_.place.p_O - touch_->radius() * n + rolled_O;
  if (touch_->law == ContactLaw::kFrictionless) {
    return {Planar(n.dot(displacement_O) * n), Eigen::Vector3d::Zero()};
  }
  return {Planar(displacement_O), Planar(rolled_O)};
}

// Returns the direction of the tool when it touched at `place`, interpolated from the last image.
Eigen::Vector2d Estimator::DirectionAtTouch(const BoundaryPlace& place,
                                            const ToolPlace& tool) const noexcept {
  const ToolPlace& last = press_.tool;
  const Eigen::Vector2d path = tool.centre_O - last.centre_O;
  const Eigen::Vector2d touched_O = place.p_O + touch_->radius() * place.normal_O;
  const double gone = (touched_O - last.centre_O).dot(path) / path.squaredNorm();
  if (last.d_O.isZero(0) || !std::isfinite(gone)) return tool.d_O;
  return (last.d_O + std::clamp(gone, 0.0, 1.0) * (tool.d_O - last.d_O)).normalized();
}

// Returns the distance by which the corner of a tilted flat face touches before its centre [m].
double Estimator::CornerAhead() const noexcept {
  if (touch_->is_round()) return 0;
  const Eigen::Vector2d &n = press_.place.normal_O, &d = press_.tool.d_O;
  return touch_->reach() * std::abs(d.x() * n.y() - d.y() * n.x());
}

// Update of contact, force and local model.
bool Estimator::UpdateContact(const CompensatedTip& tip) noexcept {
  Stopwatch lap;
  const Eigen::Isometry3d& X_SO = registration_.X_SO;
  const Eigen::Vector3d p_S_tip = tool_view_.ToSlave(tip.p_I);
  const ToolPlace tool = ToolAt(p_S_tip);
  const BoundaryPlace& place = touch_->contact->Move(tool.centre_O);
  const bool touching = touch_->contact->in_contact();
  times_.contact.Add(lap.Lap());
  ForecastIndentation(place);
  checks_us_ += lap.Lap();

  const bool goes_on = touching && rules_.in_contact() && place.p_O == press_.place.p_O;
  press_ = {place, goes_on ? press_.d_O : DirectionAtTouch(place, tool), tool, {}};
  if (touching) press_.motion = MotionOf(tool);
  const ContactResponse response = touch_->Press(place, press_.motion);
  times_.mechanics.Add(lap.Lap());

  estimate_.p_S_tip = p_S_tip;
  estimate_.p_S_contact = X_SO * Planar(place.p_O);
  estimate_.depth = touching ? std::max(0.0, -place.gap) : 0.0;
  rules_.Touch(touching, &estimate_);
  if (response.validity == Validity::kFailed || !response.force_O.allFinite()) {
    EstimateBuilder::LoseForce({Validity::kFailed, FailedCheck::kNone, "the model has no solution"},
                               &estimate_);
    return false;
  }
  UpdateLocalModel(place, response);
  SetPressForce(place, response, GapSigma(place, tip.covariance));
  return true;
}

// `sigma`: of the tip's distance from the surface [m].
void Estimator::SetPressForce(const BoundaryPlace& place, const ContactResponse& response,
                              double sigma) noexcept {
  const double stiffness = (response.stiffness_O * Planar(place.normal_O)).norm();
  if (!rules_.in_contact()) {
    cue_.Reset();
    rules_.SetForce(Eigen::Vector3d::Zero(), stiffness * HiddenDepth(place.gap, sigma),
                    {Validity::kValid}, &estimate_);
    rules_.SetMoment(std::nullopt, 0, touch_->reach(), &estimate_);
    return;
  }
  DetectPuncture(estimate_.depth);
  const Eigen::Isometry3d& X_SO = registration_.X_SO;
  // The depth has an error in pixels, and the force is proportional to it.
  const double relative =
      std::hypot(std::hypot(touch_->WidthAt(place).sigma, touch_->RoundSigma(response)),
                 pixel_tolerance_, plane_error_);
  const double relative_error = relative * response.force_O.norm();
  rules_.SetForce(-(X_SO.linear() * response.force_O),
                  std::hypot(stiffness * sigma, relative_error),
                  {response.validity, FailedCheck::kNone, response.flag_reason}, &estimate_);
  std::optional<Eigen::Vector3d> moment = response.moment_O;
  if (moment) {
    const Eigen::Vector3d p_O_tip = X_SO.inverse() * estimate_.p_S_tip;
    const Eigen::Vector3d arm = Planar(place.p_O) + press_.motion.displacement_O - p_O_tip;
    moment = -(X_SO.linear() * (*moment + arm.cross(response.force_O)));
  }
  rules_.SetMoment(moment, response.moment_sigma, touch_->reach(), &estimate_);
}

void Estimator::Examine(const cv::Mat& image, double tip_sigma, bool is_solved) noexcept {
  Stopwatch lap;
  const Findings findings = checks_.Examine(
      {.image = image,
       .tip = observation_.tip,
       .object = sighting(),
       .encoder = Innovation(),
       .is_broken = rules_.broken(),
       .is_solved = is_solved,
       .indentation_O = press_.motion.displacement_O.head<2>() / view_.pixel(),
       .normal_O = press_.place.normal_O,
       .indentation_sigma = forecast_.sigma(),
       .tip_sigma = tip_sigma,
       .place_sigma =
           std::hypot(anchor_sigma_, registration_.sigma, CornerAhead()) / view_.pixel()});
  estimate_.Add(findings.verdict);
  estimate_.sigma *= findings.widening;
  times_.checks.Add(checks_us_ + lap.Lap());
}

LocalModel Estimator::LocalAt(const Eigen::Vector3d& p_S_tip) noexcept {
  if (rules_.in_contact() || !p_S_tip.allFinite()) return estimate_.local_model;
  touch_->probe->Reset();
  const BoundaryPlace& place = touch_->probe->Move(ToolAt(p_S_tip).centre_O);
  if (touch_->probe->in_contact()) return estimate_.local_model;
  const ContactResponse response = touch_->Respond(place, {});
  if (response.validity != Validity::kFailed) UpdateLocalModel(place, response);
  return estimate_.local_model;
}

bool Estimator::MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept {
  // Without a patch the plane follows the tool: the contact of a round tool grows with the depth,
  // which no patch describes, and `extruded` would have to prepare every cell.
  if (!p_S_tip.allFinite() || touch_->is_round() || touch_->prepares_places()) return false;
  touch_->probe->Reset();
  const Eigen::Vector3d p_O_tip = registration_.X_SO.inverse() * p_S_tip;
  const int element = touch_->probe->Move(p_O_tip.head<2>()).element;
  const auto stiffness = [this](const Eigen::Vector3d& p_O, int cell, const Eigen::Vector3d&) {
    BoundaryPlace place;
    place.element = cell;
    place.p_O = p_O.head<2>();
    return StiffnessInSlave(touch_->Respond(place, {}), registration_.X_SO);
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
  // The master renders the apex.
  next.reference =
      registration_.X_SO * Planar(TipOf(place, press_.tool.d_O, Eigen::Vector2d::Zero()));
  next.normal = R * Planar(place.normal_O);
  next.stiffness =
      touch_->SecantPart(response, place) * StiffnessInSlave(response, registration_.X_SO);
  next.valid_radius = touch_->deformation->info().range * touch_->mesh.length_unit;
  next.in_contact = rules_.in_contact();
  estimate_.local_model = Revised(next, estimate_.local_model);
}

}  // namespace palpate
