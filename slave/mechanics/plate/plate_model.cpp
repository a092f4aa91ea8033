#include "slave/mechanics/plate/plate_model.h"

#include <cmath>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using plate::Touch;

PlateModel::Params Checked(const PlateModel::Params& params) {
  plate::RequirePlate({params.radius, params.thickness}, params.young_modulus,
                      params.poisson_ratio);
  RequirePositive("range", params.range);
  return params;
}

}  // namespace

PlateModel::PlateModel(const Params& params)
    : PlateSurface({Checked(params).radius, params.thickness}), params_(params) {
  const double nu = params_.poisson_ratio;
  const double slenderness = params_.thickness / params_.radius;
  const double flexural_modulus = params_.young_modulus / (12 * (1 - nu * nu));
  force_unit_ =
      flexural_modulus * params_.thickness * params_.thickness * slenderness;  // no overflow of t^3
  info_.kind = "plate";
  info_.dof = 1;
  info_.range = params_.range * slenderness / 2;
  info_.remark =
      "small deflections: the force is 10 % too low at half the thickness, 30 % at one thickness";
}

bool PlateModel::TryRespond(std::span<const Contact> contacts,
                            std::span<ContactResponse> responses) {
  if (!IsSameSet()) Prepare();
  prepared_ = SolveForces();
  if (!prepared_) return Fail("displaced points are too close to be distinguished");
  if (!(forces_.allFinite() && std::isfinite((force_unit_ * forces_).sum()) &&
        (forces_.size() == 0 || deflections_.cwiseAbs().maxCoeff() <= plate::kAbsurd))) {
    return Fail("the solution is not finite or too large");
  }
  std::size_t sought = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Touch& touch = touches_[i];
    const Index first = firsts_[i];
    ContactResponse& response = responses[i];
    double w = deflections_[first];
    double stiffness = 0;
    if (touch.is_sought()) {
      w = pressed_.deflection(sought);
      stiffness = pressed_.Stiffness(sought++);
    } else {
      stiffness = pressed_.StiffnessAt(compliance_, first);
    }
    response = {};
    response.force_O.z() = touch.moved()
                               ? -force_unit_ * forces_.segment(first, firsts_[i + 1] - first).sum()
                               : contacts[i].prescribed_O.z();
    response.displacement_O.z() = -params_.radius * w;
    response.stiffness_O(2, 2) = force_unit_ / params_.radius * stiffness;
    response.validity = std::abs(w) * params_.radius <= params_.range * params_.thickness
                            ? Validity::kValid
                            : Validity::kExtrapolated;
  }
  return true;
}

void PlateModel::Prepare() {
  known_ = touches_;
  places_.clear();
  firsts_.assign(1, 0);
  pressed_.Clear();
  for (const Touch& touch : touches_) {
    plate::AppendPlaces(touch.disc, touch.face, false, &places_);
    const Index first = firsts_.back();
    firsts_.push_back(static_cast<Index>(places_.size()));
    if (touch.is_sought()) {
      pressed_.Add({first, firsts_.back() - first, touch.is_rigid(), !touch.moved()});
    }
  }
  const Index count = firsts_.back();
  compliance_.resize(count, count);
  for (Index j = 0; j < count; ++j) {
    const plate::PressedPlace& load = places_[static_cast<std::size_t>(j)];
    for (Index i = 0; i < count; ++i) {
      compliance_(i, j) = plate::Deflection(load, places_[static_cast<std::size_t>(i)].disc.centre);
    }
  }
  forces_.setZero(count);
  deflections_.setZero(count);
}

// Solves for the forces of the moved contacts, from their prescribed deflections minus the
// deflections caused by the loads.
bool PlateModel::SolveForces() {
  values_.clear();
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const Touch& touch = touches_[i];
    const double value = touch.moved() ? touch.value : touch.value / force_unit_;
    if (touch.is_sought()) values_.push_back(value);
    if (!touch.is_sought()) forces_[firsts_[i]] = value;
  }
  deflections_.setZero();
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    if (!touches_[i].is_sought()) {
      deflections_ += compliance_.col(firsts_[i]) * forces_[firsts_[i]];
    }
  }
  if (!pressed_.Solve(compliance_, deflections_, values_, &forces_)) return false;
  deflections_.noalias() = compliance_ * forces_;
  return true;
}

double PlateModel::DisplacementAt(const Vector2d& x) noexcept {
  double w = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const double force = forces_[static_cast<Index>(i)];
    if (force != 0) w += force * plate::Deflection(places_[i], x);
  }
  return -params_.radius * w;
}

}  // namespace palpate
