#include "slave/pipeline/load/plate_load_identifier.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "slave/mechanics/plate/green.h"
#include "slave/mechanics/plate/plate_law.h"
#include "slave/mechanics/plate/plate_surface.h"
#include "slave/pipeline/load/load_identifier.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHidden = 2.5;  // standard deviations: loads up to twice that do not stand out
constexpr double kLeastScatter = 0.25;  // of the stated sigmas
constexpr double kRemembered = 0.99;    // of the evidence, from picture to picture
constexpr double kTensionSigmas = 3.5;
constexpr double kTensionFlagged = 0.5;  // one sigma, of what it makes of the force
constexpr double kTensionTold = 0.5;     // one sigma of what the scene tells, of itself
constexpr double kTensionShare = 0.02;   // of the force, that a wrong tension may make
constexpr double kMostLeftOut = 0.25;    // share of the points that may contradict the others
constexpr double kForgetsRest = 0.1;     // of the scatter at rest, from picture to picture
constexpr double kModelError = 0.03;     // of the largest deflection: may be the model's own, rms
constexpr double kClearly = 1.5;         // times the scatter at rest: two dozen points' chance
constexpr double kTold = 20;     // points that what is told of their sigmas weighs as much as
constexpr double kTogether = 4;  // points whose errors go together where they are more than noise

// What a plate works out for a tool that it has not met, and its memory for a press beside the
// centre.
void WarmUp(PlateSurface& plate, double width) {
  Contact contact;
  contact.p_O.x() = plate.radius() / 2;
  contact.width = width;
  contact.prescribed_O.z() = -plate.thickness();
  ContactResponse response;
  plate.Respond(std::span(&contact, 1), std::span(&response, 1));
  plate.Reset();
}

}  // namespace

PlateLoadIdentifier::PlateLoadIdentifier(std::unique_ptr<PlateSurface> plate, double width,
                                         std::unique_ptr<PlateSurface> finer,
                                         std::unique_ptr<PlateSurface> tighter, double more,
                                         double prestress)
    : plate_(std::move(plate)),
      finer_(std::move(finer)),
      tighter_(std::move(tighter)),
      width_(width),
      told_tension_(kTensionTold * prestress),
      table_(*plate_, width),
      fit_(*plate_, width, finer_.get(), {tighter_.get(), more}),
      surface_(MembraneGrid(plate_->radius())) {
  for (PlateSurface* other : {finer_.get(), tighter_.get()}) {
    if (other != nullptr) WarmUp(*other, width);
  }
}

SurfaceLoad PlateLoadIdentifier::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  const RobustPlateFit::Answer answer = fit_.Fit(points_O);
  const LoadFit& fit = answer.load;
  SurfaceLoad load;
  load.residual = fit.residual;
  load.Set({fit.validity, FailedCheck::kNone, fit.reason});
  if (fit.nothing) {
    load.Set({Validity::kValid});
    load.sigma_force = SigmaAtRest(points_O);
    const double square = answer.off * answer.off;
    rest_square_ += (rest_square_ > 0 ? kForgetsRest : 1) * (square - rest_square_);
  } else if (fit.validity != Validity::kFailed) {
    load.p_O = {fit.p_O.x(), fit.p_O.y(), 0};
    load.force = fit.force;
    load.depth = -fit_.answered().Displacement(fit_.solution(), fit.p_O);
    // Points that are put right err by that, too.
    const bool noise_alone =
        !answer.moved && std::ranges::all_of(points_O, &SurfacePoint::errs_by_noise_alone);
    const double scatter = ScatterOf(answer, noise_alone ? ScatterAtRest(answer) : 1);
    load.sigma_force =
        std::hypot(scatter * std::sqrt(fit.covariance(2, 2)), LawsShare(load) * load.force);
    const Eigen::Matrix2d place = fit.covariance.topLeftCorner<2, 2>();
    const double half = (place(0, 0) - place(1, 1)) / 2;
    load.sigma_place = scatter * std::sqrt(place.trace() / 2 + std::hypot(half, place(0, 1)));
  }
  CheckFit(answer, &load);
  if (load.force != 0) WeighTension(answer, &load);
  load_ = load;
  return load;
}

// One standard deviation of what the plate's law costs. A plate that bends only has an error of its
// own, and is valid only where it is so flat that this one counts little.
double PlateLoadIdentifier::LawsShare(const SurfaceLoad& load) const noexcept {
  const double a = plate_->radius();
  return plate::LawsSigma({.place = load.p_O.head<2>().norm() / a,
                           .deflection = load.depth / a,
                           .slenderness = plate_->thickness() / a});
}

void PlateLoadIdentifier::CheckFit(const RobustPlateFit::Answer& answer,
                                   SurfaceLoad* load) const noexcept {
  if (load->validity == Validity::kExtrapolated && load->reason.empty()) {
    load->Fail(FailedCheck::kModelRange, "the indentation is beyond the plate model's range");
  } else if (!load->reason.empty()) {
    load->check = FailedCheck::kMisfit;
  }
  if (answer.points < 4) {
    load->Set({Validity::kTrackingLost, FailedCheck::kNone,
               "fewer than four points of the membrane are in view"});
  } else if (load->validity == Validity::kFailed) {
    return;
  } else if (answer.left_out > kMostLeftOut * answer.points) {
    load->Fail(FailedCheck::kMisfit, "more than a quarter of the points contradict the others");
  } else if (answer.cluster > 0) {
    load->Fail(FailedCheck::kMisfit,
               "neighbouring points deviate from the fitted shape to one side");
  } else if (LiesOff(answer)) {
    load->Fail(FailedCheck::kMisfit,
               "the points deviate from the fitted shape by more than at rest");
  } else if (answer.moved && !answer.put_right) {
    load->Fail(FailedCheck::kCameraMotion,
               "the cameras or the membrane's rim have moved since the rest images");
  } else if (answer.grown) {
    load->Fail(FailedCheck::kScale, "the distances of the points have changed since rest: zoom");
  } else if (!answer.flat) {
    load->Fail(FailedCheck::kRestShape,
               "the membrane was not flat at rest: bulging, or already in contact");
  }
}

// The width of a dent at a given depth tells tension at rest from stiffness; what one picture
// leaves open many tell together.
void PlateLoadIdentifier::WeighTension(const RobustPlateFit::Answer& answer,
                                       SurfaceLoad* load) noexcept {
  const LoadFitter::Sought& sought = answer.tension;
  if (!(sought.sigma > 0) || load->validity == Validity::kFailed) return;
  // Of the residuals that another tension leaves.
  const double freedom = std::max(1, answer.points - answer.left_out - 4);
  const double explained = sought.amount * sought.amount / (sought.sigma * sought.sigma);
  const double residual = answer.load.residual * answer.load.residual * (freedom + 1) - explained;
  const double scatter =
      std::sqrt(std::max(kLeastScatter * kLeastScatter, residual / freedom)) * sought.sigma;
  // Beyond the noise that the points have at rest, their errors go with the dent's shape and come
  // again with it: compression's, say.
  const double again = scatter * std::sqrt(1 - NoiseShare(answer));
  const double law = std::hypot(answer.sigma_of_law, again);
  const double weight = 1 / (scatter * scatter + answer.sigma_of_law * answer.sigma_of_law);
  tension_information_ = kRemembered * tension_information_ + weight;
  tension_score_ = kRemembered * tension_score_ + weight * sought.amount;
  tension_law_ = kRemembered * tension_law_ + weight * law;
  const double amount = tension_score_ / tension_information_;
  const double sigma =
      std::hypot(1 / std::sqrt(tension_information_), tension_law_ / tension_information_);
  // What was sure once, at the depth that tells it best, stays so.
  tension_sure_ = std::max(kRemembered * tension_sure_, std::abs(amount) - kTensionSigmas * sigma);
  tension_likely_ = std::max(kRemembered * tension_likely_, std::abs(amount) - 2 * sigma);
  const double likely = std::max(kTensionFlagged * tension_likely_, SigmaOfTension(amount, sigma));
  const double doubt = std::abs(sought.force) * likely;
  load->sigma_force = std::hypot(load->sigma_force, std::min(doubt, std::abs(load->force) / 2));
  if (std::abs(sought.force) * tension_sure_ > kTensionShare * std::abs(load->force)) {
    load->Fail(FailedCheck::kMisfit,
               "the width of the indentation does not fit the scene's prestress");
  }
}

// By how much the points scatter, in the sigmas told of them: as they do in this picture, if less
// than told as far as there are enough of them to say so, else as was known before, whose square is
// `told_square`. What they scatter beyond their noise at rest neighbours share: it does not average
// out as fast.
double PlateLoadIdentifier::ScatterOf(const RobustPlateFit::Answer& answer,
                                      double told_square) const noexcept {
  const double freedom = std::max(1, answer.points - answer.left_out - 3);
  const double told = answer.load.residual < 1 ? kTold : 0;
  const double noise = NoiseShare(answer);
  const double seen =
      answer.load.residual * answer.load.residual * (noise + (1 - noise) * kTogether);
  return std::sqrt((told * told_square + freedom * seen) / (told + freedom));
}

// Square of what the points scattered while nothing was pressed, in the sigmas told of them now; 1:
// unknown, or no less than told.
double PlateLoadIdentifier::ScatterAtRest(const RobustPlateFit::Answer& answer) const noexcept {
  const double sigma = answer.off / answer.load.residual;
  return rest_square_ > 0 && sigma > 0 ? std::min(1.0, rest_square_ / (sigma * sigma)) : 1;
}

// Of the residuals' square, by what the points scattered while nothing was pressed; 1: unknown.
double PlateLoadIdentifier::NoiseShare(const RobustPlateFit::Answer& answer) const noexcept {
  const double square = answer.off * answer.off;
  return rest_square_ > 0 && square > rest_square_ ? rest_square_ / square : 1;
}

// Noise alone leaves as much as at rest, the plate's law a share of the deepest.
bool PlateLoadIdentifier::LiesOff(const RobustPlateFit::Answer& answer) const noexcept {
  const double law = kModelError * answer.deepest;
  return answer.deepest > 0 && NoiseShare(answer) < 1 / (kClearly * kClearly) &&
         answer.off * answer.off - rest_square_ > law * law;
}

// By how much the tension may be another one than the scene's, rms about that, where the scene
// names one, by what it tells beforehand and what the dents tell: `amount`, `sigma` [N/m]. A
// membrane that is told to hang loose does.
double PlateLoadIdentifier::SigmaOfTension(double amount, double sigma) const noexcept {
  if (!(told_tension_ > 0)) return 0;
  const double told = 1 / (told_tension_ * told_tension_), seen = 1 / (sigma * sigma);
  return std::hypot(seen * amount / (told + seen), 1 / std::sqrt(told + seen));
}

// Where no load stands out: half of what may hide in the noise, five standard deviations of a load
// at the centre, from the small-deflection shape's size and the stiffness of first touch.
double PlateLoadIdentifier::SigmaAtRest(const std::vector<SurfacePoint>& points_O) const noexcept {
  const plate::Disc disc{{0, 0}, width_ / 2 / plate_->radius()};
  const double under_load = plate::Deflection(disc, Vector2d(0, 0));
  double square = 0;
  for (const SurfacePoint& point : points_O) {
    const Vector2d x = point.p_S_rest.head<2>() / plate_->radius();
    const double variance = point.covariance(2, 2);
    if (!point.seen || !(x.norm() <= 1) || !(variance > 0)) continue;
    const double shape = plate::Deflection(disc, x) / under_load;
    square += shape * shape / variance;
  }
  return square > 0 ? kHidden * table_.At(0, 0).stiffness / std::sqrt(square) : 0;
}

LoadIdentifier::Press PlateLoadIdentifier::PressAt(const Vector3d& p_O, double depth) noexcept {
  const PressTable::Press press = table_.At(p_O.head<2>().norm(), depth);
  return {press.force, press.stiffness, press.valid};
}

void PlateLoadIdentifier::Nearest(const Vector3d& p_O_tip, Vector3d* p_O,
                                  Vector3d* n_O) const noexcept {
  const double r = p_O_tip.head<2>().norm();
  const double inside = r > plate_->radius() ? plate_->radius() / r : 1;
  *p_O = {inside * p_O_tip.x(), inside * p_O_tip.y(), 0};
  *n_O = Vector3d::UnitZ();
}

void PlateLoadIdentifier::Displacements(std::vector<Vector3d>* u_O) {
  if (load_.force != 0) return fit_.answered().Displacements(fit_.solution(), u_O);
  u_O->assign(surface_.nodes.size(), Vector3d::Zero());
}

void PlateLoadIdentifier::NodalForces(std::vector<Vector3d>* f_O) {
  SpreadLoad(surface_, load_.p_O, load_.n_O, width_, load_.force * load_.n_O, f_O);
}

void PlateLoadIdentifier::Reset() {
  fit_.Reset();
  plate_->Reset();
  if (finer_ != nullptr) finer_->Reset();
  if (tighter_ != nullptr) tighter_->Reset();
  tension_information_ = tension_score_ = tension_law_ = 0;
  tension_sure_ = tension_likely_ = 0;
  rest_square_ = 0;
  load_ = {};
}

}  // namespace palpate
