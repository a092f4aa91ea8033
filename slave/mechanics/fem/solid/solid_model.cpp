#include "slave/mechanics/fem/solid/solid_model.h"

#include <algorithm>
#include <string>
#include <utility>

#include "shared/text/text.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMaxRounds = 25;  // of the search for the nodes that touch a tool
// A node pulls or is inside a tool if it is by more than this part of the largest force or the
// depth.
constexpr double kTouchSlack = 1e-6;
constexpr double kGuess = 0.5;  // of the depth: largest gap of nodes that touch at first [by Hertz]
constexpr char kUnknownPress = 2;

// Checks all parameters before the expensive work starts.
VolumeModel::Traits CheckedTraits(const SolidMesh& mesh, const HeldNodes& held,
                                  const SolidParams& params, Progress* progress) {
  Announce(mesh, params, progress);
  const SolidParams checked = Checked(params);
  RequireTets(mesh, held);
  const double length_unit = LargerSide(mesh.nodes);
  return {.nodes_per_element = params.nodes_per_element(),
          .length_unit = length_unit,
          .force_unit = params.young_modulus * length_unit * length_unit,
          .poisson_ratio = params.poisson_ratio,
          .has_pressure = checked.HasPressureUnknown(),
          .is_dynamic = params.dynamic(),
          .finds_tools = !params.dynamic(),
          .weighs = !params.options.gravity_O.isZero(0),
          .range = params.linear() ? params.range : 0,
          .step = params.dynamic() ? params.options.step : 0};
}

}  // namespace

SolidModel::SolidModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
                       Progress* progress)
    : VolumeModel(mesh, held, CheckedTraits(mesh, held, params, progress)),
      params_(params),
      mesh_(MakeTetMesh(mesh, traits_.nodes_per_element, traits_.length_unit)),
      layout_((ReportProgress(progress, "mesh and pattern", 0.3), mesh_), traits_.has_pressure),
      body_(mesh_, layout_,
            MaterialLaw(params_.options.law, params_.poisson_ratio, params_.options.terms)),
      progress_(progress, params_.linear()),
      equilibrium_((ReportProgress(progress, "mesh and pattern", 0.6), layout_), body_,
                   params_.SolverOptions(&progress_)),
      supports_(mesh_, layout_, held, body_.NodeVolumes()),
      statics_(equilibrium_, supports_, progress_, params_.linear(), layout_.size()) {
  if (layout_.has_pressure() && !equilibrium_.solver().is_direct()) {
    RefuseValue("poisson_ratio", params_.poisson_ratio,
                "below 0.49 on this mesh, whose factor with a pressure unknown needs " +
                    std::to_string(equilibrium_.solver().memory_bytes() >> 20U) +
                    " MiB, or a coarser mesh");
  }
  const FemOptions& o = params_.options;
  const VectorXd zero = VectorXd::Zero(layout_.size());
  weight_ = state_.x = state_.target = state_.loads = zero;
  state_.balance.force = state_.balance.given = zero;
  const VectorXd volumes = body_.NodeVolumes();
  const double unit = traits_.length_unit;
  const Vector3d pull = params_.density * unit / params_.young_modulus * o.gravity_O;
  for (int node = 0; node < mesh_.node_count(); ++node) {
    weight_.segment<3>(layout_.first(node)) = volumes[node] * pull;
  }
  if (params_.dynamic()) {
    motion_.emplace(o, layout_, body_, params_.density * unit * unit / params_.young_modulus,
                    equilibrium_, state_);
  }
  Reset();
  ReportProgress(progress, "mesh and pattern", 1);
  Describe(progress);
}

// Describes cost and memory; factorises once, if this is the fastest solution, to measure its time.
void SolidModel::Describe(Progress* progress) {
  info_.dof = static_cast<std::size_t>(layout_.size());
  ReportProgress(progress, "first solution", 0);
  const auto before = std::chrono::steady_clock::now();
  if (params_.linear() && !params_.dynamic()) {
    Respond({}, {});
    info_.update_us = 1e6 * SecondsSince(before);
  }
  const SymmetricSolver& solver = equilibrium_.solver();
  Reset();
  info_.memory_bytes =
      solver.memory_bytes() +
      static_cast<std::size_t>(layout_.pattern().nonZeros()) * 12 * (params_.dynamic() ? 6 : 3) +
      mesh_.connectivity.size() * 40;
  SetRemark(std::string(mesh_.nodes_per_element == 10 ? "tet10" : "tet4") +
            (layout_.has_pressure() ? ", mixed pressure" : "") +
            (solver.is_direct() ? ", direct solver" : ", conjugate gradients"));
  NotePrecompute();
  ReportProgress(progress, "first solution", 1);
}

void SolidModel::Rest() {
  state_.Rest();
  statics_.Reset();
  if (motion_) motion_->Reset();
}

bool SolidModel::SolveUnder(std::span<const Contact> contacts) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!places()[i].holds.empty() && IsFar(contacts[i])) return Fail(kFarTool);
  }
  GuessTouching(contacts);
  is_settled_ = true;
  for (int round = 0;; ++round) {
    if (!Prescribe(contacts)) return Fail("a contact moves fixed nodes");
    if (motion_) return motion_->Step() || Fail(equilibrium_.failure());
    // The solver may not recover from such states.
    if (inversion().elements > 0 && !params_.linear()) Rest();
    if (!statics_.Solve(&state_)) {
      return Fail(statics_.failure().empty() ? equilibrium_.failure() : statics_.failure());
    }
    if (!ChangeTouching(contacts)) return true;
    if (round == kMaxRounds) {
      is_settled_ = false;
      return true;
    }
    FixTouched();
  }
}

// The nodes that touch at first, if a tool now presses and did not before, or the other way round.
void SolidModel::GuessTouching(std::span<const Contact> contacts) {
  bool has_changed = false;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto& holds = places()[i].holds;
    if (holds.empty()) continue;
    const double depth = -places()[i].axis_O.dot(contacts[i].prescribed_O);
    const auto nearest = std::ranges::min_element(holds, {}, &ToolHold::gap);
    const char presses = depth > nearest->gap ? 1 : 0;
    if (presses_[i] == presses) continue;
    presses_[i] = presses;
    has_changed = true;
    const bool is_glued = contacts[i].radius == 0 && depth <= 0;
    for (std::size_t k = 0; k < holds.size(); ++k) {
      const bool guess = presses != 0 && holds[k].gap < kGuess * depth;
      touches_[i][k] = guess || is_glued || &holds[k] == &*nearest ? 1 : 0;
    }
  }
  if (has_changed) FixTouched();
}

// Releases nodes that pull and lets nodes touch that are inside a tool. False: there are none.
bool SolidModel::ChangeTouching(std::span<const Contact> contacts) {
  bool has_changed = false;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactPlace& place = places()[i];
    if (place.holds.empty() || presses_[i] == 0) continue;
    const Vector3d& n = place.axis_O;
    const double depth = -n.dot(contacts[i].prescribed_O);
    double largest = 0;
    for (const PlaceWeight& at : place.nodes) {
      largest = std::max(largest, std::abs(n.dot(ReactionAt(at.place))));
    }
    for (std::size_t k = 0; k < place.nodes.size(); ++k) {
      const int node = place.nodes[k].place;
      const double sunk = -n.dot(traits_.length_unit * DisplacementAt(node));
      const bool touches = touches_[i][k] != 0;
      const bool leaves = touches && n.dot(ReactionAt(node)) > kTouchSlack * largest;
      const bool enters = !touches && depth - place.holds[k].gap - sunk > kTouchSlack * depth;
      if (!leaves && !enters) continue;
      touches_[i][k] = enters ? 1 : 0;
      has_changed = true;
    }
  }
  return has_changed;
}

double SolidModel::FollowedPart(const Contact& contact, const ContactPlace& place,
                                std::size_t k) const {
  const auto number = static_cast<std::size_t>(&place - places().data());
  if (place.holds.empty()) return 1;
  const double depth = -place.axis_O.dot(contact.prescribed_O);
  if (contact.radius > 0 && depth <= 0) return 0;
  return presses_[number] != 0 ? 1 - place.holds[k].gap / depth : 1;
}

// Determines the fixed unknowns and the rows of the contacts.
bool SolidModel::Hold(std::span<const Contact> contacts) {
  Balance& balance = state_.balance;
  balance.rows.clear();
  first_row_.assign(contacts.size(), -1);
  touches_.resize(contacts.size());
  presses_.assign(contacts.size(), kUnknownPress);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].kind != Contact::Kind::kDisplacement) continue;
    const ContactPlace& place = places()[i];
    touches_[i].assign(place.nodes.size(), 1);
    first_row_[i] = static_cast<int>(balance.rows.size());
    for (int c = 0; c < 3 && place.is_point; ++c) {
      PointRow row;
      for (const auto& [node, weight] : place.nodes) {
        row.weights.emplace_back(layout_.first(node) + c, weight);
      }
      balance.rows.push_back(std::move(row));
    }
  }
  balance.row_force.setZero(static_cast<int>(balance.rows.size()));
  state_.row_target.assign(balance.rows.size(), 0);
  FixTouched();
  return true;
}

// Fixes the nodes that contacts hold now.
void SolidModel::FixTouched() {
  Balance& balance = state_.balance;
  equilibrium_.Changed();
  supports_.Hold(&balance);
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const ContactPlace& place = places()[i];
    if (first_row_[i] < 0 || place.is_point) continue;
    for (std::size_t k = 0; k < place.nodes.size(); ++k) {
      if (touches_[i][k] == 0) continue;
      const int first = layout_.first(place.nodes[k].place);
      for (int c = 0; c < 3; ++c) balance.fixed[Index(first + c)] = 1;
    }
  }
  if (!params_.dynamic()) supports_.Pin(&balance);
}

// False: a contact moves a fixed node.
bool SolidModel::Prescribe(std::span<const Contact> contacts) {
  state_.target.setZero();
  state_.loads = weight_;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactPlace& place = places()[i];
    if (contacts[i].kind == Contact::Kind::kForce) {
      const Vector3d force = contacts[i].prescribed_O / traits_.force_unit;
      for (const auto& [node, share] : place.nodes) {
        state_.loads.segment<3>(layout_.first(node)) += share * force;
      }
      continue;
    }
    const Vector3d moved = contacts[i].prescribed_O / traits_.length_unit;
    if (place.is_point) {
      for (int c = 0; c < 3; ++c) state_.row_target[Index(first_row_[i] + c)] = moved[c];
      continue;
    }
    for (std::size_t k = 0; k < place.nodes.size(); ++k) {
      const int node = place.nodes[k].place;
      if (touches_[i][k] == 0) continue;
      if (supports_.Forbids(node, moved)) return false;
      state_.target.segment<3>(layout_.first(node)) = FollowedPart(contacts[i], place, k) * moved;
    }
  }
  return true;
}

VolumeModel::Inversion SolidModel::FindInversion() const {
  const ElasticBody::Jacobians found = body_.FindJacobians(state_.x);
  return {found.inverted, found.first_inverted};
}

}  // namespace palpate
