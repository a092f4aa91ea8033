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
constexpr double kMostLeftOut = 0.25;  // share of the points that may contradict the others

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
                                         std::unique_ptr<PlateSurface> finer)
    : plate_(std::move(plate)),
      finer_(std::move(finer)),
      width_(width),
      table_(*plate_, width),
      fit_(*plate_, width, finer_.get()),
      surface_(MembraneGrid(plate_->radius())) {
  if (finer_ != nullptr) WarmUp(*finer_, width);
}

SurfaceLoad PlateLoadIdentifier::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  const RobustPlateFit::Answer answer = fit_.Fit(points_O);
  const LoadFit& fit = answer.load;
  SurfaceLoad load;
  load.residual = fit.residual;
  load.validity = fit.validity;
  load.why = fit.reason;
  if (fit.nothing) {
    load.validity = Validity::kValid;
    load.why = {};
    load.sigma_force = SigmaAtRest(points_O);
  } else if (fit.validity != Validity::kFailed) {
    load.p_O = {fit.p_O.x(), fit.p_O.y(), 0};
    load.force = fit.force;
    load.depth = -fit_.answered().Displacement(fit.p_O);
    const double scatter = std::max(1.0, fit.residual);
    load.sigma_force =
        std::hypot(scatter * std::sqrt(fit.covariance(2, 2)), LawsShare(load) * load.force);
    const Eigen::Matrix2d place = fit.covariance.topLeftCorner<2, 2>();
    const double half = (place(0, 0) - place(1, 1)) / 2;
    load.sigma_place = scatter * std::sqrt(place.trace() / 2 + std::hypot(half, place(0, 1)));
  }
  Judge(answer, &load);
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

// What speaks against the load, the gravest last.
void PlateLoadIdentifier::Judge(const RobustPlateFit::Answer& answer,
                                SurfaceLoad* load) const noexcept {
  const auto doubt = [load](std::string_view why) {
    load->validity = Worse(load->validity, Validity::kExtrapolated);
    load->why = why;
  };
  if (load->validity == Validity::kExtrapolated && load->why.empty()) {
    load->why = "the press is beyond the plate model's range";
  }
  if (answer.points < 4) {
    load->validity = Validity::kTrackingLost;
    load->why = "fewer than four points of the membrane are in view";
  } else if (load->validity == Validity::kFailed) {
    return;
  } else if (answer.left_out > kMostLeftOut * answer.points) {
    doubt("more than a quarter of the points contradict the others");
  } else if (answer.moved) {
    doubt("the eyes or the membrane's rim have moved since the rest picture");
  }
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
  if (load_.force != 0) return fit_.answered().Displacements(u_O);
  u_O->assign(surface_.nodes.size(), Vector3d::Zero());
}

void PlateLoadIdentifier::NodalForces(std::vector<Vector3d>* f_O) {
  SpreadLoad(surface_, load_.p_O, load_.n_O, width_, load_.force * load_.n_O, f_O);
}

void PlateLoadIdentifier::Reset() {
  fit_.Reset();
  plate_->Reset();
  if (finer_ != nullptr) finer_->Reset();
  load_ = {};
}

}  // namespace palpate
