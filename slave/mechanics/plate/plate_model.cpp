#include "slave/mechanics/plate/plate_model.h"

#include <cmath>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using plate::Touch;

constexpr double kAbsurd = 1e6;      // radii
constexpr double kRigidRange = 0.6;  // of the range: a plate stretches sooner around a rigid tool

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
    const Index first = first_[i], count = first_[i + 1] - first;
    ContactResponse& response = responses[i];
    const double w = deflections_[first];
    response = {};
    response.force_O.z() = touches_[i].moved() ? -force_unit_ * forces_.segment(first, count).sum()
                                               : contacts[i].prescribed_O.z();
    response.displacement_O.z() = -params_.radius * w;
    response.stiffness_O(2, 2) =
        force_unit_ / params_.radius * moved_.Stiffness(compliance_, first, count);
    const double range = params_.range * (touches_[i].rigid ? kRigidRange : 1);
    response.validity = std::abs(w) * params_.radius <= range * params_.thickness
                            ? Validity::kValid
                            : Validity::kExtrapolated;
  }
  return true;
}

bool PlateModel::Prepare() {
  known_ = touches_;
  plate::Divide(touches_, params_.thickness / params_.radius, &parts_);
  moved_.Clear();
  first_.clear();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].contact == first_.size()) first_.push_back(static_cast<Index>(i));
    if (touches_[parts_[i].contact].moved()) moved_.Add(static_cast<Index>(i));
  }
  first_.push_back(static_cast<Index>(parts_.size()));
  FillCompliance();
  return moved_.Factorise(compliance_);
}

void PlateModel::FillCompliance() {
  const double slenderness = params_.thickness / params_.radius;
  const std::size_t count = parts_.size();
  compliance_.resize(static_cast<Index>(count), static_cast<Index>(count));
  for (std::size_t j = 0; j < count; ++j) {
    const Touch& load = touches_[parts_[j].contact];
    const double face =
        load.rigid ? plate::RigidToolOf(load.disc.radius, slenderness).compliance : 0;
    for (std::size_t i = 0; i < count; ++i) {
      compliance_(static_cast<Index>(i), static_cast<Index>(j)) =
          plate::MeanDeflection(parts_[j].disc, parts_[i].disc) +
          (parts_[i].contact == parts_[j].contact ? face : 0);
    }
  }
}

// Forces of the moved contacts: what their prescribed deflection leaves after the loads' share.
bool PlateModel::SolveForces() {
  const auto count = static_cast<Index>(parts_.size());
  forces_.resize(count);
  deflections_.resize(count);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const bool moved = touches_[parts_[i].contact].moved();
    forces_[static_cast<Index>(i)] = moved ? 0 : ValueOf(i) / force_unit_;
  }
  const auto& moved = moved_.contacts();
  deflections_.noalias() = compliance_ * forces_;
  solution_.resize(static_cast<Index>(moved.size()));
  for (std::size_t m = 0; m < moved.size(); ++m) {
    solution_[static_cast<Index>(m)] =
        ValueOf(static_cast<std::size_t>(moved[m])) - deflections_[moved[m]];
  }
  moved_.Solve(solution_);
  for (std::size_t m = 0; m < moved.size(); ++m) {
    forces_[moved[m]] = solution_[static_cast<Index>(m)];
  }
  deflections_.noalias() = compliance_ * forces_;
  for (const Index i : moved) deflections_[i] = ValueOf(static_cast<std::size_t>(i));
  return forces_.allFinite() && std::isfinite((force_unit_ * forces_).sum()) &&
         (count == 0 || deflections_.cwiseAbs().maxCoeff() <= kAbsurd);
}

double PlateModel::DisplacementAt(const Vector2d& x) noexcept {
  double w = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    w += forces_[static_cast<Index>(i)] * plate::Deflection(parts_[i].disc, x);
  }
  return -params_.radius * w;
}

}  // namespace palpate
