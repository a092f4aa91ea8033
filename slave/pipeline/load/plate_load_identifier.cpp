#include "slave/pipeline/load/plate_load_identifier.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "slave/checks/load/load_checks.h"
#include "slave/checks/points/noise_limits.h"
#include "slave/mechanics/plate/green.h"
#include "slave/mechanics/plate/plate_law.h"
#include "slave/mechanics/plate/plate_surface.h"
#include "slave/pipeline/load/plate_limits.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Computes a plate's response to a new tool in advance, and allocates memory for a contact beside
// the centre.
void WarmUp(PlateSurface& plate, const PlateSurface::Tool& tool) {
  const Contact contact = PlateSurface::ToolContact(
      Contact::Kind::kDisplacement, {plate.radius() / 2, 0}, tool, -plate.thickness());
  ContactResponse response;
  plate.Respond(std::span(&contact, 1), std::span(&response, 1));
  plate.Reset();
}

}  // namespace

PlateLoadIdentifier::PlateLoadIdentifier(std::unique_ptr<PlateSurface> plate,
                                         const PlateSurface::Tool& tool,
                                         std::unique_ptr<PlateSurface> finer,
                                         std::unique_ptr<PlateSurface> tighter, double more,
                                         double prestress)
    : plate_(std::move(plate)),
      finer_(std::move(finer)),
      tighter_(std::move(tighter)),
      tool_(tool),
      table_(*plate_, tool),
      fit_(*plate_, tool, finer_.get(), {tighter_.get(), more}),
      surface_(MembraneGrid(plate_->radius())),
      checks_(MakePlateChecks(plate_->radius(), plate_->thickness(), prestress)) {
  for (PlateSurface* warmed : {plate_.get(), finer_.get(), tighter_.get()}) {
    if (warmed != nullptr) WarmUp(*warmed, tool);
  }
}

SurfaceLoad PlateLoadIdentifier::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  const PlateFit found = fit_.Fit(points_O);
  const LoadFit& fit = found.load;
  load_ = {};
  load_.residual = fit.residual;
  if (found.points < 4) {
    load_.Set({Validity::kTrackingLost, FailedCheck::kNone,
               "fewer than four points of the membrane are in view"});
    return load_;
  }
  FitSample sample{.points_O = points_O,
                   .load = load_,
                   .points = found.points,
                   .left_out = found.left_out,
                   .freedom = found.points - found.left_out - 3,
                   .sigma = found.sigma,
                   .deepest = found.deepest,
                   .plate = &found};
  if (fit.nothing) {
    load_.Set({Validity::kValid});
    load_.sigma_force = SigmaAtRest(points_O);
    const double square = fit.residual * fit.residual;
    rest_square_ += (rest_square_ > 0 ? PlateLimits::kForgetsRest : 1) * (square - rest_square_);
  }
  sample.rest_residual = std::sqrt(rest_square_);
  if (!fit.nothing) {
    SetLoad(sample);
    if (fit.validity == Validity::kFailed) return load_;
    if (fit.validity == Validity::kExtrapolated && fit.reason.empty()) {
      sample.beyond_range = "the indentation is beyond the plate model's range";
    }
  }
  load_.Take(checks_.Examine(sample));
  return load_;
}

void PlateLoadIdentifier::SetLoad(const FitSample& sample) noexcept {
  const LoadFit& fit = sample.plate->load;
  const bool is_beyond_range = fit.validity == Validity::kExtrapolated && fit.reason.empty();
  load_.Set({is_beyond_range ? Validity::kValid : fit.validity,
             fit.reason.empty() ? FailedCheck::kNone : FailedCheck::kMisfit, fit.reason});
  if (fit.validity == Validity::kFailed) return;
  load_.p_O = {fit.p_O.x(), fit.p_O.y(), 0};
  load_.force = fit.force;
  load_.depth = -fit_.solution().responses().front().displacement_O.z();
  const double scatter = ScatterOf(sample);
  load_.sigma_force =
      std::hypot(scatter * std::sqrt(fit.covariance(2, 2)), LawsShare(load_) * load_.force);
  const Eigen::Matrix2d place = fit.covariance.topLeftCorner<2, 2>();
  const double half = (place(0, 0) - place(1, 1)) / 2;
  load_.sigma_place = scatter * std::sqrt(place.trace() / 2 + std::hypot(half, place(0, 1)));
}

// Returns one standard deviation of the error of the plate's law. A plate without stretching has
// another error, and is valid only for deflections so small that this one is negligible.
double PlateLoadIdentifier::LawsShare(const SurfaceLoad& load) const noexcept {
  const double a = plate_->radius();
  return plate::LawsSigma({.place = load.p_O.head<2>().norm() / a,
                           .deflection = load.depth / a,
                           .slenderness = plate_->thickness() / a});
}

// Returns the scatter of the points relative to their sigmas: that of this image if it is smaller
// than reported and there are enough points, else that at rest. Scatter beyond the noise at rest is
// common to neighbours, so it averages out more slowly.
double PlateLoadIdentifier::ScatterOf(const FitSample& sample) noexcept {
  const PlateFit& fit = *sample.plate;
  const double residual = fit.load.residual;
  // The errors of compensated points are not only noise.
  const bool by_noise_alone =
      !fit.moved && std::ranges::all_of(sample.points_O, &SurfacePoint::errs_by_noise_alone);
  const double rest = sample.rest_residual;
  const double at_rest = by_noise_alone && rest > 0 ? std::min(1.0, rest * rest) : 1;
  const double freedom = std::max(1, sample.freedom);
  const double stated = residual < 1 ? PlateLimits::kReportedWeight : 0;
  const double noise = sample.NoiseShare();
  const double seen = residual * residual * (noise + (1 - noise) * PlateLimits::kPointsPerError);
  return std::sqrt((stated * at_rest + freedom * seen) / (stated + freedom));
}

// Returns the sigma of the force if no load is significant: half of the largest load that noise may
// hide, which is five standard deviations of a load at the centre, from the small-deflection shape
// and the stiffness of the first contact.
double PlateLoadIdentifier::SigmaAtRest(const std::vector<SurfacePoint>& points_O) const noexcept {
  const plate::Disc disc{{0, 0}, tool_.width / 2 / plate_->radius()};
  const double under_load = plate::Deflection(disc, Vector2d(0, 0));
  double square = 0;
  for (const SurfacePoint& point : points_O) {
    const Vector2d x = point.p_S_rest.head<2>() / plate_->radius();
    const double variance = point.covariance(2, 2);
    if (!point.seen || !(x.norm() <= 1) || !(variance > 0)) continue;
    const double shape = plate::Deflection(disc, x) / under_load;
    square += shape * shape / variance;
  }
  return square > 0 ? NoiseLimits::kSignificant / 2 * table_.At(0, 0).stiffness / std::sqrt(square)
                    : 0;
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
  SpreadLoad(surface_, load_.p_O, load_.n_O, tool_.width, load_.force * load_.n_O, f_O);
}

void PlateLoadIdentifier::Reset() {
  fit_.Reset();
  plate_->Reset();
  if (finer_ != nullptr) finer_->Reset();
  if (tighter_ != nullptr) tighter_->Reset();
  checks_.Reset();
  rest_square_ = 0;
  load_ = {};
}

}  // namespace palpate
