#include "slave/pipeline/camera/estimator.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>
#include <stdexcept>

#include <Eigen/LU>
#include <spdlog/fmt/fmt.h>

#include "slave/mechanics/make_model.h"
#include "slave/pipeline/local_model/patch_maker.h"
#include "slave/pipeline/sense.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/contour_registration.h"
#include "slave/vision/tool_end.h"

namespace palpate {
namespace {

using Limits = CameraLimits;

constexpr double kScaleSigmas = 3;
constexpr double kOtherObject = 0.3;  // a size so different is that of something else
constexpr double kFarSigmas = 3;      // above the surface, a tip surely touches nothing
constexpr double kMoves = 1;          // what is less is no motion that somebody has to own [px]
constexpr double kArmSigmas = 3;      // how far eyes and arm may part besides
constexpr double kDentNear = 15;      // from the surface, where a dent is looked for [px]
// Sigma of a dent computed: [px], relative, besides relative as elements are long for the tool.
constexpr double kDentFloor = 0.2, kDentModel = 0.05, kDentMesh = 0.1;
constexpr double kDentSigmas = 3.5;
constexpr double kFirstDent = 1;      // at which a round tool's is taken before it touches [px]
constexpr double kDentDeepens = 0.1;  // part of its depth after which it is taken anew
constexpr double kDentStands = 0.7;   // part of a dent that needs no second look
// Pictures that must agree before a dent is believed again, or a tip and an object that were lost.
constexpr int kDistrust = 3;
constexpr int kMostApart = 7;          // places in a row: a dent, or a cover, where none is to be
constexpr double kBlurMoves = 1;       // sigma of the tip where no edge is left [px]
constexpr double kMostTipSigma = 0.4;  // [px]
// Where the tip's sigma is more, its dent tells: known to this part of the tool's width, and not
// farther from the tip seen [px]. Rough is then what is more than this part of the dent.
constexpr double kDentTells = 0.1, kRoughTip = 6, kRough = 0.12;
constexpr double kLeastNoise = 0.5;  // of a camera's pictures [1/255 of full scale]
constexpr int kUnconfirmed = 6;      // pictures in which a dent may stay out of sight
constexpr double kCovered = 0.3;     // of the tip's template, unless its dent is seen

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

// An outline that fits badly, or has another size than the scene's, would make every force wrong.
void RequireCredible(const Scene& scene, const OutlineFit& fit, std::size_t points) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error(fmt::format("{}: object.geometry: {}", scene.file.string(), why));
  };
  const double larger = fit.scale - 1;
  const double least = std::max(Limits::kMostScale, kScaleSigmas * fit.scale_sigma);
  if (std::abs(larger) > least && std::abs(larger) < kOtherObject) {
    refuse(
        fmt::format("the object in the first picture is {:.1f} % {} than it says: accepted is "
                    "{:g} %: check camera.pixel ({:g} um would fit) and its sizes",
                    100 * std::abs(larger), larger > 0 ? "larger" : "smaller",
                    100 * Limits::kMostScale, 1e6 * scene.sense.Find<Camera>()->pixel / fit.scale));
  }
  if (!fit.found) {
    refuse(fmt::format(
        "the outline seen in the first picture does not fit it ({} of {} contour points agree): "
        "check object.pose, camera.pixel and sense.contour.start",
        fit.inliers, points));
  }
  if (fit.rms_px > Limits::kMostResidual) {
    refuse(
        fmt::format("the outline seen in the first picture is {:.1f} px rms away from it: "
                    "accepted is {:g} px: check its shape and sense.contour.start",
                    fit.rms_px, Limits::kMostResidual));
  }
}

// What the first picture shows of the tool against what scene and manipulator say of it. `d_I`:
// along which it points; zero: nobody knows.
FailedCheck DoubtOfTool(const Scene& scene, const cv::Mat& first, const Eigen::Vector2d& p_I_tip,
                        const Eigen::Vector2d& d_I, double width_px) {
  if (!scene.sense.Find<TipTracking>()->template_file.empty() || d_I.isZero(0)) {
    return FailedCheck::kNone;
  }
  const auto seen = SeeToolEnd(first, GreyFormat(first), p_I_tip, d_I, width_px);
  if (!seen) return FailedCheck::kNone;
  if (std::abs(seen->beyond) > Limits::kToolElsewhere) return FailedCheck::kArm;
  const bool aside = std::abs(seen->aside) > Limits::kToolElsewhere;
  const bool wide = std::abs(seen->width / width_px - 1) > Limits::kToolWidth;
  if (aside == wide) return FailedCheck::kNone;  // both: something covers a side of it
  return aside ? FailedCheck::kArm : FailedCheck::kScale;
}

Eigen::Vector3d Planar(const Eigen::Vector2d& v) {
  return {v.x(), v.y(), 0};
}

// Depth that a tip has, rms, which is seen `gap` above the surface by eyes of that sigma [m]: the
// part of a normal distribution below the surface.
double Missed(double gap, double sigma) {
  const double z = sigma > 0 ? gap / sigma : kFarSigmas;
  if (!(z < kFarSigmas)) return 0;
  const double below = std::erfc(z / std::numbers::sqrt2) / 2;
  const double density = std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
  return sigma * std::sqrt(std::max(0.0, (1 + z * z) * below - z * density));
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
  if (!eyes_->rest_contour_I().empty()) {
    watch_.emplace(first.image, eyes_->rest_contour_I(), view_, registration_.X_SO, touch_->mesh);
  }
  tool_.d_I = eyes_->tool_direction_I();
  tool_.width = tool_width_ / view_.pixel();
  if (p_S_tip_reported) {
    tool_doubt_ =
        DoubtOfTool(scene, first.image, view_.ToImage(*p_S_tip_reported), tool_.d_I, tool_.width);
  }
  is_noisy_ = eyes_->noise() > kLeastNoise;
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
  RequireCredible(scene, fit, contour_I.size());
  registration_ = {true, fit.X_SO, fit.rms_px, fit.inliers};
  rest_sigma_ = fit.sigma_px * view_.pixel();
}

std::unique_ptr<TouchModel> Estimator::Prepare(const Scene& scene, Progress* progress) const {
  auto touch = std::make_unique<TouchModel>();
  touch->mesh = MeshOutline(scene, seen_);
  touch->deformation = MakeModel(scene, touch->mesh, progress);
  touch->held = HeldVertices(scene, touch->mesh);
  if (scene.tool->shape == Tool::Shape::kRound) {
    touch->indenter = std::make_unique<RoundIndenter>(TouchablePlaces(touch->mesh),
                                                      scene.tool->radius, scene.model.contact);
  } else {
    touch->width.emplace(touch->mesh, scene);
  }
  touch->contact = std::make_unique<BoundaryContact>(touch->mesh);
  touch->probe = std::make_unique<BoundaryContact>(touch->mesh);
  return touch;
}

void Estimator::Adopt(std::unique_ptr<TouchModel> touch, const Scene& scene) {
  touch_ = std::move(touch);
  rules_.Adopt(scene);
  cue_.Adopt(scene.model.puncture_from);
  law_ = scene.model.contact;
  dent_element_ = -1;
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

void Estimator::Reset() noexcept {
  eyes_->Reset();
  touch_->contact->Reset();
  rules_.Reset();
  cue_.Reset();
  if (watch_) watch_->Reset();
  distrust_ = unconfirmed_ = regained_ = 0;
  arm_in_picture_.Reset();
  arm_on_object_.Reset();
  owner_.Reset();
  trend_.Reset();
  motion_ = {};
}

const ContactEstimate& Estimator::Feel(const Frame& frame,
                                       const std::optional<ArmWord>& said) noexcept {
  Stopwatch total, lap;
  felt_.sample = frame.sequence;
  felt_.sensed_at = frame.sensed_at;
  felt_.events.Clear();
  observation_ = &eyes_->Look(frame.image, frame.sequence, frame.sensed_at);
  times_.vision.Add(lap.Lap());
  felt_.seen_at = Clock::now();
  LookAtObject(frame.image);
  const bool frozen = IsFrozen(frame.image);
  checks_us_ = lap.Lap();

  const TipObservation& tip = observation_->tip;
  felt_.moment.reset();
  felt_.details.score = tip.found ? std::optional(tip.score) : std::nullopt;
  if (registration_.measured) felt_.details.registration = registration_.rms_px;
  TellSighting();
  rules_.Track(tip.found, &felt_);
  if (tip.found) {
    const Eigen::Vector2d p_I = PutRight(tip);
    Touch(view_.ToSlave(p_I));
    if (said) AskArm(*said);
    if (said) FollowObject(*said);
    if (tool_doubt_ != FailedCheck::kNone) EstimateRules::Doubt(tool_doubt_, &felt_);
    if (regained_ > 0) EstimateRules::Doubt(FailedCheck::kTip, &felt_);
    if (frozen) EstimateRules::Doubt(FailedCheck::kFrozen, &felt_);
  } else {
    EstimateRules::LoseForce(Validity::kTrackingLost, FailedCheck::kTip, &felt_);
  }
  const bool is_seen = !watch_ || rules_.broken() || watch_->sighting().known;
  const bool is_lost = !tip.found || !is_seen;
  regained_ = is_lost ? kDistrust : std::max(0, regained_ - 1);
  times_.total.Add(total.Lap());
  return felt_;
}

void Estimator::TellSighting() noexcept {
  felt_.details.contour = felt_.details.camera_motion = std::nullopt;
  if (!watch_ || !watch_->sighting().known) return;
  felt_.details.contour = watch_->sighting().residual_px;
  felt_.details.camera_motion = watch_->sighting().motion.shift.norm();
}

// Where the tip is in the first picture's frame [px], and how well that is known. A tip that is
// only roughly known, under a cover, is told by the dent it makes if that is seen well.
Eigen::Vector2d Estimator::PutRight(const TipObservation& tip) noexcept {
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
  if (tip.sigma < kMostTipSigma || !object.dent_known || !rules_.in_contact()) return p_I;
  if (rules_.broken()) return p_I;
  const double sigma =
      std::hypot(std::sqrt(object.dent_covariance.trace()), dent_sigma_ * object.dent_O.norm());
  const Eigen::Vector2d dent_S = registration_.X_SO.linear().topLeftCorner<2, 2>() * object.dent_O;
  const Eigen::Vector3d p_S = felt_.p_S_contact + view_.pixel() * Planar(dent_S);
  const Eigen::Vector2d by_dent = view_.ToImage(p_S);
  if (!(sigma < kDentTells * tool_.width) || (by_dent - p_I).norm() > kRoughTip) return p_I;
  tip_sigma_ = sigma;
  tip_covariance_ = sigma * sigma * Eigen::Matrix2d::Identity();
  return by_dent;
}

// The same picture again, to the last bit: where there is noise no camera takes that twice.
bool Estimator::IsFrozen(const cv::Mat& image) noexcept {
  const bool comparable = image.size() == last_image_.size() &&
                          image.type() == last_image_.type() && image.isContinuous() &&
                          last_image_.isContinuous();
  const bool same =
      comparable && !image.empty() && image.data != last_image_.data &&
      std::memcmp(image.data, last_image_.data, image.total() * image.elemSize()) == 0;
  last_image_ = image;
  return same && is_noisy_;
}

void Estimator::AskArm(const ArmWord& said) noexcept {
  const TipObservation& tip = observation_->tip;
  const double tolerance = (Limits::kArmParts + kArmSigmas * tip_sigma_) * view_.pixel();
  const bool in_picture = arm_in_picture_.Agree(view_.ToSlave(tip.p_I), said, tolerance);
  const bool on_object = arm_on_object_.Agree(felt_.p_S_tip, said, tolerance);
  if (!in_picture && !on_object) EstimateRules::Doubt(FailedCheck::kArm, &felt_);
}

// A camera that was bumped shows all elsewhere, and nothing is; where the object moves the tool has
// to follow it.
void Estimator::FollowObject(const ArmWord& said) noexcept {
  if (!watch_ || !watch_->sighting().known) return;
  const ObjectSighting& object = watch_->sighting();
  const Eigen::Vector2d& p_I = observation_->tip.p_I;
  const Eigen::Vector3d p_S_seen = view_.ToSlave(p_I);
  const Eigen::Vector3d p_S_on_object = view_.ToSlave(object.motion.Back(p_I));
  owner_.See(p_S_seen, p_S_on_object, said, kMoves * view_.pixel());
  motion_ = {};
  if (owner_.is_objects()) motion_.offset = p_S_seen - p_S_on_object;
  trend_.Add(felt_.sensed_at, motion_.offset, object.sigma_px * view_.pixel());
  motion_.velocity = trend_.velocity();
  motion_.velocity_error = trend_.error();
}

// What the object's edge tells with the dent that is to be expected where the tip is now.
void Estimator::LookAtObject(const cv::Mat& image) noexcept {
  if (!watch_) return;
  const TipObservation& tip = observation_->tip;
  if (tip.found) tool_.p_I_tip = tip.p_I;
  if (tip.found && dent_element_ >= 0) {
    const Eigen::Vector3d p_S = view_.ToSlave(watch_->sighting().motion.Back(tip.p_I));
    const Eigen::Vector3d way_S = p_S - felt_.p_S_contact;
    const bool touches = rules_.in_contact() || way_S.dot(felt_.local_model.normal) < 0;
    const bool presses = touches && !rules_.broken();
    dent_O_.setZero();
    if (presses) {
      dent_O_ = (registration_.X_SO.linear().transpose() * way_S).head<2>() / view_.pixel();
    }
  }
  watch_->Look(image, tool_, dent_O_);
  // A dent that is gone is out of reach of a look where it should be: whichever look finds more of
  // the edge is right.
  const double expected = DepthOf(dent_O_);
  if (!cue_.IsArmed(expected * view_.pixel())) return;
  const ObjectSighting dented = watch_->sighting();
  const bool stands = dented.known && dented.dent_known;
  if (stands && DepthOf(dented.dent_O) > kDentStands * expected) return;
  const ObjectSighting& flat = watch_->Look(image, tool_, Eigen::Vector2d::Zero());
  const auto found = [](const ObjectSighting& seen) { return seen.known ? seen.agreeing : 0; };
  if (found(flat) <= found(dented)) watch_->Look(image, tool_, dent_O_);
}

// Of a displacement of the pressed patch, along the surface's normal [any length].
double Estimator::DepthOf(const Eigen::Vector2d& dent_O) const noexcept {
  return -dent_O.dot(pressed_place_.normal_O);
}

// `depth` [m]
void Estimator::LookForPuncture(double depth) noexcept {
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

// How the outline moves with the patch at `place`, while the tool is there or comes near. A round
// tool's dent changes its shape as it deepens.
void Estimator::ExpectDent(const BoundaryPlace& place) noexcept {
  const bool near = place.gap < kDentNear * view_.pixel();
  const double depth = touch_->indenter ? std::max(-place.gap, kFirstDent * view_.pixel()) : 0;
  const bool deepens = std::abs(depth - dent_depth_) > kDentDeepens * dent_depth_;
  if (!watch_ || (near && place.element == dent_element_ && !deepens)) return;
  dent_element_ = -1;
  watch_->ForgetDent();
  if (!near) return;
  const Eigen::Vector3d n = Planar(place.normal_O), t(-n.y(), n.x(), 0);
  const double unit = touch_->indenter ? -depth : touch_->mesh.length_unit;
  if (!FieldOf(place, unit * n, &dent_along_n_)) return;
  // Without friction only the part along the normal presses.
  const bool slides = law_ == ContactLaw::kFrictionless;
  if (!slides && !FieldOf(place, std::abs(unit) * t, &dent_along_t_)) return;
  for (const int axis : {0, 1}) {
    auto& along = axis == 0 ? dent_along_x_ : dent_along_y_;
    along.resize(dent_along_n_.size());
    for (std::size_t i = 0; i < along.size(); ++i) {
      along[i] = n[axis] / unit * dent_along_n_[i];
      if (!slides) along[i] += t[axis] / std::abs(unit) * dent_along_t_[i];
    }
  }
  const double element =
      touch_->mesh.elements[static_cast<std::size_t>(place.element)].length() / view_.pixel();
  const Eigen::Vector2d p_I = view_.ToImage(registration_.X_SO * Planar(place.p_O));
  watch_->SetDent(dent_along_x_, dent_along_y_, {p_I, tool_.width, element});
  dent_sigma_ = kDentModel + kDentMesh * element / (element + tool_.width);
  dent_element_ = place.element;
  dent_depth_ = depth;
}

// Displacements of the outline's vertices [m]. False: not known. Across the normal a round tool
// moves as a flat one does.
bool Estimator::FieldOf(const BoundaryPlace& place, const Eigen::Vector3d& displacement_O,
                        std::vector<Eigen::Vector3d>* field) noexcept {
  const bool presses = displacement_O.dot(Planar(place.normal_O)) != 0;
  const ContactResponse response =
      presses ? Respond(place, displacement_O) : RespondFlat(place, displacement_O);
  if (response.validity == Validity::kFailed) return false;
  touch_->deformation->Displacements(field);
  return true;
}

// How well it is known how far the tip is from the surface, one standard deviation [m]: across it,
// where the force changes most.
double Estimator::GapSigma(const BoundaryPlace& place) const noexcept {
  const Eigen::Vector3d p_S = registration_.X_SO * Planar(place.p_O);
  const Eigen::Vector3d n_S = registration_.X_SO.linear() * Planar(place.normal_O);
  const Eigen::Vector2d n_I =
      (view_.ToImage(p_S + view_.pixel() * n_S) - view_.ToImage(p_S)).normalized();
  return std::hypot(view_.pixel() * std::sqrt(n_I.dot(tip_covariance_ * n_I)), rest_sigma_);
}

void Estimator::Touch(const Eigen::Vector3d& p_S_tip) noexcept {
  Stopwatch lap;
  const Eigen::Isometry3d& X_SO = registration_.X_SO;
  const Eigen::Vector3d p_O_tip = X_SO.inverse() * p_S_tip;
  const BoundaryPlace& place = touch_->contact->MoveTip(p_O_tip.head<2>());
  const bool touching = touch_->contact->in_contact();
  times_.contact.Add(lap.Lap());
  ExpectDent(place);
  times_.checks.Add(checks_us_ + lap.Lap());

  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  if (touching) {
    displacement.head<2>() = p_O_tip.head<2>() - place.p_O;
    const Eigen::Vector3d n = Planar(place.normal_O);
    if (law_ == ContactLaw::kFrictionless) displacement = n.dot(displacement) * n;
  }
  const ContactResponse response = Respond(place, displacement);
  pressed_place_ = place;
  pressed_by_ = displacement;
  times_.mechanics.Add(lap.Lap());

  felt_.p_S_tip = p_S_tip;
  felt_.p_S_contact = X_SO * Planar(place.p_O);
  felt_.depth = touching ? std::max(0.0, -place.gap) : 0.0;
  rules_.Touch(touching, &felt_);
  if (response.validity == Validity::kFailed || !response.force_O.allFinite()) {
    return EstimateRules::LoseForce(Validity::kFailed, FailedCheck::kNone, &felt_);
  }
  UpdateLocalModel(place, response);
  const Eigen::Vector2d dent_O = displacement.head<2>() / view_.pixel();
  if (!touching) {
    cue_.Reset();
    const double stiffness = (response.stiffness_O * Planar(place.normal_O)).norm();
    const double unseen = Missed(place.gap, GapSigma(place));
    rules_.TellForce(Eigen::Vector3d::Zero(), stiffness * unseen, Validity::kValid, &felt_);
    return Judge(dent_O, tip_sigma_);
  }
  LookForPuncture(felt_.depth);
  const double stiffness = (response.stiffness_O * Planar(place.normal_O)).norm();
  rules_.TellForce(
      -(X_SO.linear() * response.force_O),
      std::hypot(stiffness * GapSigma(place), WidthAt(place).sigma * response.force_O.norm()),
      response.validity, &felt_);
  if (!rules_.broken()) {
    if (touch_->indenter) {
      felt_.moment = -(X_SO.linear() * touch_->indenter->MomentAbout(p_O_tip));
    }
    return Judge(dent_O, tip_sigma_);
  }
  // Through a broken membrane nothing is dented, and the force is zero whatever the edge says; the
  // snake, which would follow the tool inwards, begins at the rest surface again.
  eyes_->RestartContour();
}

bool Estimator::IsDented(const Eigen::Vector2d& dent_O, double sigma_px) const noexcept {
  const ObjectSighting& seen = watch_->sighting();
  if (!seen.dent_known) return true;
  const double sigma2 = kDentFloor * kDentFloor + dent_sigma_ * dent_sigma_ * dent_O.squaredNorm() +
                        sigma_px * sigma_px;
  const Eigen::Matrix2d C = seen.dent_covariance + sigma2 * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d error = seen.dent_O - dent_O;
  return error.dot(C.inverse() * error) < kDentSigmas * kDentSigmas;
}

// Doubts the force just told where the object's edge says otherwise. `dent_O`: displacement of the
// contact's patch as the tip tells it [px].
void Estimator::Judge(const Eigen::Vector2d& dent_O, double sigma_px) noexcept {
  if (!watch_) return;
  const ObjectSighting& seen = watch_->sighting();
  if (!seen.known) return EstimateRules::Doubt(FailedCheck::kRegistration, &felt_);
  if (seen.motion.shift.norm() > Limits::kMostShift ||
      std::abs(seen.motion.angle) > Limits::kMostTurn) {
    EstimateRules::Doubt(FailedCheck::kCameraMotion, &felt_);
  }
  if (std::abs(seen.motion.growth) > Limits::kMostGrowth) {
    EstimateRules::Doubt(FailedCheck::kScale, &felt_);
  }
  const bool rough = tip_sigma_ > std::max(kMostTipSigma, kRough * dent_O.norm());
  const bool blurred =
      seen.sharpness < Limits::kSharpness || seen.sharpness_at_rest < Limits::kSharpAtRest;
  if (blurred || rough || seen.exposure > Limits::kOverexposed) {
    EstimateRules::Doubt(FailedCheck::kPicture, &felt_);
  }
  if (seen.apart > kMostApart) EstimateRules::Doubt(FailedCheck::kDent, &felt_);
  distrust_ = IsDented(dent_O, sigma_px) ? std::max(0, distrust_ - 1) : kDistrust;
  const bool confirmed = seen.dent_known || dent_O.norm() < Limits::kSmallDent;
  unconfirmed_ = confirmed ? 0 : unconfirmed_ + 1;
  if (distrust_ > 0 || unconfirmed_ > kUnconfirmed) {
    EstimateRules::Doubt(FailedCheck::kDent, &felt_);
  }
  if (!confirmed && observation_->tip.covered > kCovered) {
    EstimateRules::Doubt(FailedCheck::kTipCovered, &felt_);
  }
}

ContactResponse Estimator::Respond(const BoundaryPlace& place,
                                   const Eigen::Vector3d& displacement_O) noexcept {
  if (!touch_->indenter) return RespondFlat(place, displacement_O);
  const ToolIndentation at{Planar(place.p_O), Planar(place.normal_O), displacement_O};
  return touch_->indenter->Press(at, touch_->deformation.get());
}

ContactResponse Estimator::RespondFlat(const BoundaryPlace& place,
                                       const Eigen::Vector3d& displacement_O) noexcept {
  const double factor = WidthAt(place).factor;
  const Contact contact{Contact::Kind::kDisplacement, Planar(place.p_O), place.element, tool_width_,
                        displacement_O};
  ContactResponse response;
  touch_->deformation->Respond(std::span(&contact, 1), std::span(&response, 1));
  response.force_O *= factor;
  response.stiffness_O *= factor;
  return response;
}

ToolWidth::Share Estimator::WidthAt(const BoundaryPlace& place) noexcept {
  return touch_->width ? touch_->width->At(place, touch_->deformation.get()) : ToolWidth::Share{};
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

bool Estimator::MakePatch(const Eigen::Vector3d& p_S_tip, TouchPatch* patch) noexcept {
  // A round tool's contact grows with the depth, which no patch tells: the plane follows it.
  if (!p_S_tip.allFinite() || touch_->indenter) return false;
  touch_->probe->Reset();
  const Eigen::Vector3d p_O_tip = registration_.X_SO.inverse() * p_S_tip;
  const int element = touch_->probe->MoveTip(p_O_tip.head<2>()).element;
  const auto stiffness = [this](const Eigen::Vector3d& p_O, int cell, const Eigen::Vector3d&) {
    BoundaryPlace place;
    place.element = cell;
    place.p_O = p_O.head<2>();
    return StiffnessInSlave(Respond(place, Eigen::Vector3d::Zero()));
  };
  const bool frictionless = law_ == ContactLaw::kFrictionless;
  const bool known =
      FillPatch(touch_->mesh, element, registration_.X_SO, frictionless, stiffness, patch);
  patch->full_depth = patch->valid_depth =
      touch_->deformation->info().range * touch_->mesh.length_unit;
  // Whoever watches the shape sees the tool's contact, not what was asked here.
  if (pressed_place_.element >= 0) static_cast<void>(Respond(pressed_place_, pressed_by_));
  return known;
}

// A passive contact has a symmetric stiffness; collocation leaves a small skew part, which would
// create energy in the operator's hand.
Eigen::Matrix3d Estimator::StiffnessInSlave(const ContactResponse& response) const noexcept {
  const Eigen::Matrix3d& R = registration_.X_SO.linear();
  if (response.validity == Validity::kFailed) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d K_O = 0.5 * (response.stiffness_O + response.stiffness_O.transpose());
  return R * K_O * R.transpose();
}

// A round tool's force is not its stiffness times the depth, as the master takes it: the contact
// was smaller before. That share of the stiffness which at this depth gives this force [-].
double Estimator::SecantPart(const ContactResponse& response,
                             const BoundaryPlace& place) const noexcept {
  const Eigen::Vector3d n = Planar(place.normal_O);
  const double linear = n.dot(response.stiffness_O * n) * -place.gap;
  if (!touch_->indenter || !(linear > 0)) return 1;
  return std::clamp(-response.force_O.dot(n) / linear, 0.0, 1.0);
}

void Estimator::UpdateLocalModel(const BoundaryPlace& place,
                                 const ContactResponse& response) noexcept {
  const Eigen::Matrix3d& R = registration_.X_SO.linear();
  LocalModel next;
  next.reference = registration_.X_SO * Planar(place.p_O);
  next.normal = R * Planar(place.normal_O);
  next.stiffness = SecantPart(response, place) * StiffnessInSlave(response);
  next.valid_radius = touch_->deformation->info().range * touch_->mesh.length_unit;
  next.in_contact = rules_.in_contact();
  felt_.local_model = Revised(next, felt_.local_model);
}

}  // namespace palpate
