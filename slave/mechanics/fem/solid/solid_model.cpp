#include "slave/mechanics/fem/solid/solid_model.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <string>

#include "shared/geometry/index.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kAbsurd = 1e6;  // larger sides

double SideOf(const SolidMesh& mesh) {
  const double side = LargerSide(mesh.nodes);
  if (side > 0 && std::isfinite(side)) return side;
  throw std::invalid_argument("mesh: accepted is a finite extent > 0");
}

}  // namespace

SolidModel::SolidModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
                       Progress* progress)
    : params_((Announce(mesh, params, progress), Checked(params))),
      unit_((RequireOnePerNode(held, mesh), SideOf(mesh))),
      mesh_(MakeElementMesh(mesh, params_.options.element, unit_)),
      layout_((ReportProgress(progress, "mesh and pattern", 0.3), mesh_), params_.TakesPressure()),
      body_(mesh_, layout_,
            MaterialLaw(params_.options.law, params_.poisson_ratio, params_.options.terms)),
      progress_(progress, params_.linear()),
      equilibrium_((ReportProgress(progress, "mesh and pattern", 0.6), layout_), body_,
                   params_.SolverOptions(&progress_)),
      used_(Index(mesh_.node_count()), false),
      contacts_(mesh_, used_, unit_),
      supports_(mesh_, layout_, held, body_.NodeVolumes()),
      // Of bending alone where the pressure is the elements' own.
      strain_({mesh_.surface.nodes, mesh.tets, mesh.modulus},
              layout_.has_pressure() ? HeldNodes{} : held,
              layout_.has_pressure() ? 0.0 : params_.poisson_ratio, mesh_.nodes_per_element),
      u_(mesh_.nodes.size()),
      statics_(equilibrium_, supports_, progress_, params_.linear(), layout_.size()) {
  field_mesh_ = {.vertices = mesh.nodes, .tets = mesh.tets};
  for (const int node : mesh_.connectivity) used_[Index(node)] = true;
  if (layout_.has_pressure() && !equilibrium_.solver().is_direct()) {
    throw std::invalid_argument(
        "pressure = mixed or averaged: accepted while the factorisation fits in memory; this mesh "
        "needs " +
        std::to_string(equilibrium_.solver().memory_bytes() >> 20U) + " MiB: use a coarser mesh");
  }
  const FemOptions& o = params_.options;
  const VectorXd zero = VectorXd::Zero(layout_.size());
  weight_ = state_.x = state_.target = state_.loads = zero;
  state_.balance.force = state_.balance.given = zero;
  const VectorXd volumes = body_.NodeVolumes();
  const Vector3d pull = params_.density * unit_ / params_.young_modulus * o.gravity_O;
  for (int node = 0; node < mesh_.node_count(); ++node) {
    weight_.segment<3>(layout_.first(node)) = volumes[node] * pull;
  }
  if (params_.dynamic()) {
    motion_.emplace(o, layout_, body_, params_.density * unit_ * unit_ / params_.young_modulus,
                    equilibrium_, state_);
  }
  Reset();
  ReportProgress(progress, "mesh and pattern", 1);
  Describe(progress);
}

// Factors once where that is what an answer costs least, and measures it.
void SolidModel::Describe(Progress* progress) {
  keeps_displacements_ = true;
  info_.kind = "fem";
  info_.dof = static_cast<std::size_t>(layout_.size());
  info_.elements = mesh_.element_count();
  info_.range = params_.linear() ? params_.range : 0;
  info_.step = params_.dynamic() ? params_.options.step : 0;
  ReportProgress(progress, "first solution", 0);
  const auto before = std::chrono::steady_clock::now();
  if (params_.linear() && !params_.dynamic()) {
    Respond({}, {});
    info_.update_us = 1e6 * SecondsSince(before);
  }
  const SymmetricSolver& solver = equilibrium_.solver();
  failure_ = {};
  Reset();
  info_.memory_bytes =
      solver.memory_bytes() +
      static_cast<std::size_t>(layout_.pattern().nonZeros()) * 12 * (params_.dynamic() ? 6 : 3) +
      mesh_.connectivity.size() * 40;
  info_.remark = std::string(mesh_.nodes_per_element == 10 ? "tet10" : "tet4") +
                 (layout_.has_pressure()
                      ? (mesh_.nodes_per_element == 10 ? ", mixed pressure" : ", averaged pressure")
                      : "") +
                 (solver.is_direct() ? ", direct solver" : ", conjugate gradients");
  NotePrecompute();
  ReportProgress(progress, "first solution", 1);
}

void SolidModel::Reset() {
  state_.Rest();
  inverted_ = false;
  statics_.Reset();
  if (motion_) motion_->Reset();
}

bool SolidModel::locks() const {
  constexpr double kLocks = 0.49;
  return params_.options.element == FemOptions::Element::kTet4 && !layout_.has_pressure() &&
         params_.poisson_ratio >= kLocks;
}

void SolidModel::ComputeResponses(std::span<const Contact> contacts,
                                  std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  bool answered = false;
  try {
    answered = responses.size() == contacts.size() && TryRespond(contacts, responses);
  } catch (const std::exception&) {
    failure_ = "out of memory";
    contacts_.Forget();
  }
  if (answered) return;
  if (failure_.empty()) failure_ = "the number of responses and contacts must be equal";
  std::ranges::fill(responses, ContactResponse{});
  Reset();
}

bool SolidModel::TryRespond(std::span<const Contact> contacts,
                            std::span<ContactResponse> responses) {
  if (!Acceptable(contacts) || !PrepareSet(contacts) || !Prescribe(contacts)) return false;
  return SolveState() && Fill(contacts, responses);
}

bool SolidModel::SolveState() {
  if (motion_) return motion_->Step() || Fail(equilibrium_.failure());
  if (inverted_ && !params_.linear()) Reset();  // such states may be traps
  if (statics_.Solve(&state_)) return true;
  return Fail(statics_.failure().empty() ? equilibrium_.failure() : statics_.failure());
}

bool SolidModel::Acceptable(std::span<const Contact> contacts) {
  for (const auto& contact : contacts) {
    const bool moved = contact.kind == Contact::Kind::kDisplacement;
    const double unit = moved ? unit_ : params_.young_modulus * unit_ * unit_;
    if ((contact.prescribed_O / unit).cwiseAbs().maxCoeff() <= kAbsurd) continue;
    return Fail("a value is not finite or too large");
  }
  return true;
}

// What is fixed and which rows there are, for new places.
bool SolidModel::PrepareSet(std::span<const Contact> contacts) {
  if (!contacts_.Prepare(contacts)) return Fail(contacts_.failure());
  if (!contacts_.changed() && !state_.balance.fixed.empty()) return true;
  equilibrium_.Changed();
  supports_.Hold(&state_.balance);
  state_.balance.rows.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].kind != Contact::Kind::kDisplacement) continue;
    const ContactPlace& place = contacts_.places()[i];
    for (const int node : place.moved) {
      for (int c = 0; c < 3; ++c) state_.balance.fixed[Index(layout_.first(node) + c)] = 1;
    }
    for (int c = 0; place.moved.empty() && c < 3; ++c) {
      PointRow row;
      for (const auto& [node, weight] : place.weights) {
        row.weights.emplace_back(layout_.first(node) + c, weight);
      }
      state_.balance.rows.push_back(std::move(row));
    }
  }
  state_.balance.row_force.setZero(static_cast<int>(state_.balance.rows.size()));
  state_.row_target.assign(state_.balance.rows.size(), 0);
  if (!params_.dynamic()) supports_.Pin(&state_.balance);
  return true;
}

bool SolidModel::Prescribe(std::span<const Contact> contacts) {
  state_.target.setZero();
  state_.loads = weight_;
  std::size_t row = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactPlace& place = contacts_.places()[i];
    if (contacts[i].kind == Contact::Kind::kForce) {
      const Vector3d force = contacts[i].prescribed_O / (params_.young_modulus * unit_ * unit_);
      for (const auto& [node, share] : place.weights) {
        state_.loads.segment<3>(layout_.first(node)) += share * force;
      }
      continue;
    }
    const Vector3d moved = contacts[i].prescribed_O / unit_;
    for (const int node : place.moved) {
      if (supports_.Forbids(node, moved)) return Fail("a fixed node is moved");
      state_.target.segment<3>(layout_.first(node)) = moved;
    }
    for (int c = 0; place.moved.empty() && c < 3; ++c) state_.row_target[row++] = moved[c];
  }
  return true;
}

// Of the tool on the object, nondimensional: what moved nodes lack.
Vector3d SolidModel::ForceOn(const ContactPlace& place) const {
  Vector3d force = Vector3d::Zero();
  for (const int node : place.moved) {
    force += equilibrium_.unbalanced().segment<3>(layout_.first(node));
  }
  return force;
}

void SolidModel::SetMomentOf(const Contact& contact, const ContactPlace& place,
                             ContactResponse* response) const {
  const double force_unit = params_.young_modulus * unit_ * unit_;
  const auto force_at = [&](std::size_t i) -> Vector3d {
    if (place.moved.empty()) return unit_ * place.weights[i].second * contact.prescribed_O;
    const auto first = layout_.first(place.moved[i]);
    return unit_ * force_unit * equilibrium_.unbalanced().segment<3>(first);
  };
  SetMoment(place.arms, contact.width, force_at, response);
}

// Why the answer is extrapolated; nullopt: it is not, but for single patches.
std::optional<std::string_view> SolidModel::FlagReason(double largest) {
  if (inverted_) return "elements are inside out";
  if (locks()) return "linear tetrahedra lock at this Poisson ratio";
  if (params_.linear() && largest > params_.range) return kBeyondRange;
  if (motion_ && motion_->grew()) return "the time step gained energy";
  // In equilibrium under nothing, what is left of strain is the residual's.
  const bool acts = params_.dynamic() || !state_.loads.isZero(0) || !state_.target.isZero(0) ||
                    std::ranges::any_of(state_.row_target, [](double moved) { return moved != 0; });
  if (acts && Softness() > kMostSoftness) return kStiffInBending;
  return std::nullopt;
}

double SolidModel::Softness() {
  touched_.clear();
  for (const ContactPlace& place : contacts_.places()) {
    for (const int node : place.moved) touched_.push_back(node);
    for (const auto& [node, weight] : place.weights) touched_.push_back(node);
  }
  for (std::size_t i = 0; i < u_.size(); ++i) {
    u_[i] = state_.x.segment<3>(layout_.first(static_cast<int>(i)));
  }
  return strain_.Softness(u_, touched_);
}

bool SolidModel::Fill(std::span<const Contact> contacts, std::span<ContactResponse> responses) {
  double largest = 0;
  for (int node = 0; node < mesh_.node_count(); ++node) {
    largest = std::max(largest, state_.x.segment<3>(layout_.first(node)).stableNorm());
  }
  if (!(largest <= kAbsurd)) return Fail("the solution is too large");
  inverted_ = !(body_.SmallestJacobian(state_.x) > 0);
  const std::optional<std::string_view> doubt = FlagReason(largest);
  const double force_unit = params_.young_modulus * unit_ * unit_;
  int row = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    ContactResponse response;
    const ContactPlace& place = contacts_.places()[i];
    const bool valid = !doubt && !place.coarse;
    response.validity = valid ? Validity::kValid : Validity::kExtrapolated;
    if (!valid) response.doubt = doubt.value_or(kCoarsePatch);
    if (contacts[i].kind == Contact::Kind::kForce) {
      response.force_O = contacts[i].prescribed_O;
      Vector3d mean = Vector3d::Zero();
      for (const auto& [node, share] : place.weights) {
        mean += share * state_.x.segment<3>(layout_.first(node));
      }
      response.displacement_O = unit_ * mean;
    } else {
      response.displacement_O = contacts[i].prescribed_O;
      if (place.moved.empty()) {
        response.force_O = force_unit * state_.balance.row_force.segment<3>(row);
        row += 3;
      } else {
        response.force_O = force_unit * ForceOn(place);
      }
    }
    if (!response.force_O.allFinite() || !response.displacement_O.allFinite()) {
      return Fail("the solution is not finite");
    }
    SetMomentOf(contacts[i], place, &response);
    responses[i] = response;
  }
  return true;
}

void SolidModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  u_O->clear();
  for (int node = 0; node < mesh_.vertex_count; ++node) u_O->push_back(displacement(node));
}

double SolidModel::energy() {
  const double energy = motion_ ? motion_->Energy() : equilibrium_.Energy(state_.x);
  return params_.young_modulus * unit_ * unit_ * unit_ * energy;
}

}  // namespace palpate
