#include "slave/mechanics/plate/plate_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>

#include "slave/mechanics/plate/membrane_grid.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using plate::Touch;

constexpr double kAbsurd = 1e6;  // radii

bool IsMoved(const Touch& touch) {
  return touch.kind == Contact::Kind::kDisplacement;
}

PlateModel::Params Checked(const PlateModel::Params& params) {
  plate::RequirePlate({params.radius, params.thickness}, params.young_modulus,
                      params.poisson_ratio);
  plate::RequirePositive("range", params.range);
  return params;
}

}  // namespace

PlateModel::PlateModel(const Params& params) : params_(Checked(params)) {
  const double nu = params_.poisson_ratio;
  const double slenderness = params_.thickness / params_.radius;
  const double flexural_modulus = params_.young_modulus / (12 * (1 - nu * nu));
  rigidity_ = flexural_modulus * params_.thickness * params_.thickness * params_.thickness;
  force_unit_ =
      flexural_modulus * params_.thickness * params_.thickness * slenderness;  // no overflow of t^3
  const SurfaceMesh grid = MembraneGrid(params_.radius);
  field_mesh_ = {.vertices = grid.nodes, .triangles = grid.triangles};
  info_.kind = "plate";
  info_.dof = 1;
  info_.range = params_.range * slenderness / 2;
  info_.remark = "small deflection: the force is 10 % low at half the thickness, 30 % at one";
}

void PlateModel::Respond(std::span<const Contact> contacts,
                         std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  try {
    answered_ = responses.size() == contacts.size() && TryRespond(contacts, responses);
  } catch (const std::bad_alloc&) {
    answered_ = prepared_ = false;
    failure_ = "out of memory";
  }
  if (!answered_) std::ranges::fill(responses, ContactResponse{});
}

bool PlateModel::TryRespond(std::span<const Contact> contacts,
                            std::span<ContactResponse> responses) {
  failure_ = plate::Check(contacts, {params_.radius, params_.thickness}, &touches_);
  if (!failure_.empty()) return false;
  if (!SameSet()) prepared_ = Prepare();
  if (!prepared_) {
    failure_ = "moved places are too close to be told apart";
    return false;
  }
  if (!SolveForces()) {
    failure_ = "the answer is not finite or absurdly large";
    return false;
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto touch = static_cast<Index>(i);
    ContactResponse& response = responses[i];
    const double w = deflections_[touch];
    response = {};
    response.force_O.z() =
        IsMoved(touches_[i]) ? -force_unit_ * forces_[touch] : contacts[i].prescribed_O.z();
    response.displacement_O.z() = -params_.radius * w;
    response.stiffness_O(2, 2) =
        force_unit_ / params_.radius * moved_.Stiffness(compliance_, touch);
    response.validity = std::abs(w) * params_.radius <= params_.range * params_.thickness
                            ? Validity::kValid
                            : Validity::kExtrapolated;
  }
  return true;
}

bool PlateModel::SameSet() const noexcept {
  return prepared_ && std::ranges::equal(known_, touches_, [](const Touch& a, const Touch& b) {
           return a.kind == b.kind && a.disc.centre == b.disc.centre &&
                  a.disc.radius == b.disc.radius;
         });
}

bool PlateModel::Prepare() {
  known_ = touches_;
  const auto count = static_cast<Index>(touches_.size());
  compliance_.resize(count, count);
  moved_.Clear();
  for (Index j = 0; j < count; ++j) {
    const Touch& load = touches_[static_cast<std::size_t>(j)];
    if (IsMoved(load)) moved_.Add(j);
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
    forces_[i] = IsMoved(touch) ? 0 : touch.value / force_unit_;
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

double PlateModel::Deflection(const Vector2d& x) const noexcept {
  double w = 0;
  for (std::size_t i = 0; i < known_.size(); ++i) {
    w += forces_[static_cast<Index>(i)] * plate::Deflection(known_[i].disc, x);
  }
  return w;
}

double PlateModel::Displacement(const Vector2d& p_O) noexcept {
  return answered_ ? -params_.radius * Deflection(p_O / params_.radius) : 0;
}

void PlateModel::Displacements(std::vector<Eigen::Vector3d>* u_O) {
  u_O->clear();
  for (const auto& node : MembraneGrid(1).nodes) {
    const double w = answered_ ? Deflection(node.head<2>()) : 0;
    u_O->emplace_back(0, 0, -params_.radius * w);
  }
}

}  // namespace palpate
