#include "slave/mechanics/plate/plate_model.h"

#include <cmath>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using plate::Touch;

constexpr double kAbsurd = 1e6;  // radii

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
  if (!IsSameSet()) prepared_ = Prepare();
  if (!prepared_) return Fail("displaced points are too close to be distinguished");
  if (!SolveForces()) return Fail("the solution is not finite or too large");
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto touch = static_cast<Index>(i);
    ContactResponse& response = responses[i];
    const double w = deflections_[touch];
    response = {};
    response.force_O.z() =
        touches_[i].moved() ? -force_unit_ * forces_[touch] : contacts[i].prescribed_O.z();
    response.displacement_O.z() = -params_.radius * w;
    response.stiffness_O(2, 2) =
        force_unit_ / params_.radius * moved_.Stiffness(compliance_, touch);
    response.validity = std::abs(w) * params_.radius <= params_.range * params_.thickness
                            ? Validity::kValid
                            : Validity::kExtrapolated;
  }
  return true;
}

bool PlateModel::Prepare() {
  known_ = touches_;
  const auto count = static_cast<Index>(touches_.size());
  compliance_.resize(count, count);
  moved_.Clear();
  for (Index j = 0; j < count; ++j) {
    const Touch& load = touches_[static_cast<std::size_t>(j)];
    if (load.moved()) moved_.Add(j);
    for (Index i = 0; i < count; ++i) {
      compliance_(i, j) =
          plate::Deflection(load.disc, touches_[static_cast<std::size_t>(i)].disc.centre);
    }
  }
  return moved_.Factorise(compliance_);
}

// Forces of the moved contacts: what their prescribed deflection leaves after the loads' share.
bool PlateModel::SolveForces() {
  const auto count = static_cast<Index>(touches_.size());
  forces_.resize(count);
  deflections_.resize(count);
  for (Index i = 0; i < count; ++i) {
    const Touch& touch = touches_[static_cast<std::size_t>(i)];
    forces_[i] = touch.moved() ? 0 : touch.value / force_unit_;
  }
  const auto& moved = moved_.contacts();
  deflections_.noalias() = compliance_ * forces_;
  solution_.resize(static_cast<Index>(moved.size()));
  for (std::size_t m = 0; m < moved.size(); ++m) {
    solution_[static_cast<Index>(m)] =
        touches_[static_cast<std::size_t>(moved[m])].value - deflections_[moved[m]];
  }
  moved_.Solve(solution_);
  for (std::size_t m = 0; m < moved.size(); ++m) {
    forces_[moved[m]] = solution_[static_cast<Index>(m)];
  }
  deflections_.noalias() = compliance_ * forces_;
  for (const Index i : moved) deflections_[i] = touches_[static_cast<std::size_t>(i)].value;
  return forces_.allFinite() && std::isfinite((force_unit_ * forces_).sum()) &&
         (count == 0 || deflections_.cwiseAbs().maxCoeff() <= kAbsurd);
}

double PlateModel::DisplacementAt(const Vector2d& x) noexcept {
  double w = 0;
  for (std::size_t i = 0; i < known_.size(); ++i) {
    w += forces_[static_cast<Index>(i)] * plate::Deflection(known_[i].disc, x);
  }
  return -params_.radius * w;
}

}  // namespace palpate
