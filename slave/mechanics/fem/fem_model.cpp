#include "slave/mechanics/fem/fem_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "shared/mesh/disc_patch.h"
#include "shared/text/text.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using fem::At;
using fem::NodeVector;

constexpr double kLinearRange = 0.1;  // of the larger side
constexpr double kBalanced = 1e-6;    // of the loads' sizes
// Largest and smallest path of a tool between two accepted states [edges]. [tuned:
// tool_contact_test]
constexpr double kIncrement = 0.25, kMinIncrement = 1.0 / 64;
constexpr int kRehearsed = 30'000;  // elements
// The limit for bodies whose queries use steps with the two-grid solver.
constexpr int kRehearsedInSteps = 300'000;

bool Dynamic(const FemOptions& options) {
  return options.time == FemOptions::Time::kDynamic;
}
bool Linear(const FemOptions& options) {
  return options.law == FemOptions::Law::kLinear;
}

void CheckOptions(const FemOptions& options) {
  if (options.element != FemOptions::Element::kTet4) {
    throw std::invalid_argument("element = tet10: expected tet4 in this model");
  }
  if (options.law == FemOptions::Law::kOgden ||
      (options.law == FemOptions::Law::kNeoHookean && Dynamic(options))) {
    throw std::invalid_argument(
        "law: expected linear, corotational and, at rest, neo-hookean in this model");
  }
  if (!(options.residual >= 1e-14 && options.residual < 1)) {
    RefuseValue("residual", options.residual, "1e-14 <= residual < 1");
  }
  if (!options.gravity_O.allFinite())
    throw std::invalid_argument("gravity: expected finite numbers");
  if (!Dynamic(options)) return;
  RequirePositive("step", options.step);
}

void CheckTool(const FemModel::Params& params) {
  const bool shaped =
      params.contact != ContactLaw::kBonded || params.tool.shape != Tool::Shape::kFlat;
  if (shaped && Dynamic(params.options)) {
    throw std::invalid_argument("time = dynamic: expected static with this tool and contact");
  }
  if (params.contact == ContactLaw::kFriction) RequirePositive("friction", params.friction);
}

void CheckMaterial(const Material& material, const FemOptions& options) {
  RequirePositive("young_modulus", material.young_modulus);
  if (!(material.poisson_ratio > -1 && material.poisson_ratio < 0.5)) {
    RefuseValue("poisson_ratio", material.poisson_ratio,
                "-1 < nu < 0.5 with linear tetrahedra without a pressure unknown");
  }
  const bool weighs = options.gravity_O != Vector3d::Zero();
  const bool finite = material.density >= 0 && std::isfinite(material.density);
  if (!finite || ((Dynamic(options) || weighs) && !(material.density > 0))) {
    RefuseValue("density", material.density, "more than 0 kg/m3 for motion and weight");
  }
}

// Checks all parameters before the expensive work starts.
VolumeModel::Traits CheckedTraits(const SolidMesh& mesh, const HeldNodes& held,
                                  const FemModel::Params& params, Progress* progress) {
  const FemOptions& options = params.options;
  CheckOptions(options);
  CheckMaterial(params.material, options);
  CheckTool(params);
  if (!(params.range >= 0)) RefuseValue("range", params.range, "0 (default) or more");
  RequireTets(mesh, held);
  if (progress != nullptr) {
    const auto elements = static_cast<double>(mesh.tets.size());
    progress->Expect({5e-6 * elements, static_cast<std::size_t>(1500 * elements)});
  }
  ReportProgress(progress, "numbering nodes", 0);
  const double length_unit = LargerSide(mesh.nodes);
  return {.length_unit = length_unit,
          .force_unit = params.material.young_modulus * length_unit * length_unit,
          .poisson_ratio = params.material.poisson_ratio,
          .is_dynamic = Dynamic(options),
          .weighs = options.gravity_O != Vector3d::Zero(),
          .range = params.range > 0  ? params.range
                   : Linear(options) ? kLinearRange
                                     : 0,
          .step = Dynamic(options) ? options.step : 0};
}

fem::FemBody::Params BodyParams(const FemModel::Params& params) {
  using Law = fem::TetElements::Law;
  const FemOptions::Law law = params.options.law;
  return {params.material.poisson_ratio, law == FemOptions::Law::kLinear ? Law::kLinear
                                         : law == FemOptions::Law::kNeoHookean
                                             ? Law::kNeoHookean
                                             : Law::kCorotational};
}

}  // namespace

FemModel::FemModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
                   Progress* progress)
    : VolumeModel(mesh, held, CheckedTraits(mesh, held, params, progress)),
      params_(params),
      body_(mesh, held, BodyParams(params)),
      time_unit_(traits_.length_unit *
                 std::sqrt(params.material.density / params.material.young_modulus)),
      constraints_(body_),
      gravity_(Index(body_.size())),
      f_ext_(Index(body_.size())) {
  ReportProgress(progress, "preparing the solver", 0.6);
  const FemOptions& options = params.options;
  SetGravity();
  if (Dynamic(options)) {
    stepper_.emplace(body_, fem::TimeStepper::Params{options.step / time_unit_, options.residual,
                                                     Linear(options)});
  } else {
    equilibrium_.emplace(body_, fem::StaticEquilibrium::Params{options.residual, Linear(options),
                                                               params.deadline, progress});
  }
  if (equilibrium_) {
    tools_.emplace(mesh, params.material.poisson_ratio, body_, constraints_);
    const bool is_free = !constraints_.FindFreeMotions() || constraints_.has_free_motions();
    holds_patches_ = is_free && params.contact == ContactLaw::kBonded;
  }
  Reset();
  Describe();
  ReportProgress(progress, "first solution", 0.8);
  MeasureUpdateTime(mesh);
  NotePrecompute();
  ReportProgress(progress, "ready", 1);
}

void FemModel::SetGravity() {
  const Vector3d weight = params_.material.density * params_.options.gravity_O *
                          traits_.length_unit / params_.material.young_modulus;
  for (int i = 0; i < body_.size(); ++i) {
    for (int c = 0; c < 3; ++c) At(gravity_, i).v[c] = body_.Volume(i) * weight[c];
  }
}

void FemModel::Describe() {
  for (const auto& node : body_.free()) {
    for (const double free : node.v) info_.dof += free > 0 ? 1 : 0;
  }
  info_.memory_bytes =
      body_.memory_bytes() + (stepper_ ? stepper_->memory_bytes() : equilibrium_->memory_bytes());
  SetRemark(locks() ? std::string(kLocking) : "");
}

// Measures the time of an update after a contact has moved, on meshes where that is quick.
void FemModel::MeasureUpdateTime(const SolidMesh& mesh) {
  const bool in_steps = body_.law() == fem::TetElements::Law::kNeoHookean;
  if (body_.element_count() > (in_steps ? kRehearsedInSteps : kRehearsed)) return;
  const SurfaceMesh surface = SurfaceOf(mesh);
  if (surface.triangles.empty()) return;
  Contact contact{.kind = Contact::Kind::kForce, .p_O = Centroid(surface, 0)};
  contact.prescribed_O =
      -1e-6 * params_.material.young_modulus * Area(surface, 0) * Normal(surface, 0);
  ContactResponse response;
  Respond({&contact, 1}, {&response, 1});
  contact.prescribed_O *= 2;
  const auto start = std::chrono::steady_clock::now();
  Respond({&contact, 1}, {&response, 1});
  if (response.validity != Validity::kFailed) info_.update_us = 1e6 * SecondsSince(start);
  Reset();
}

void FemModel::Rest() {
  if (stepper_) {
    stepper_->Reset();
  } else {
    equilibrium_->Reset();
  }
  if (!tools_) return;
  tools_->Reset();
  for (Contact& contact : accepted_) contact.prescribed_O.setZero();
}

bool FemModel::IsTool(const Contact& contact) const {
  if (!tools_ || contact.kind != Contact::Kind::kDisplacement) return false;
  const bool is_shaped = contact.radius > 0 || params_.tool.shape != Tool::Shape::kFlat;
  return is_shaped || (contact.width > 0 && !holds_patches_);
}

Tool FemModel::ToolAt(const Contact& contact) const {
  Tool tool = params_.tool;
  if (contact.radius > 0) tool = {.shape = Tool::Shape::kRound, .radius = contact.radius};
  return tool;
}

bool FemModel::Hold(std::span<const Contact> contacts) {
  constraints_.Clear();
  hold_.assign(contacts.size(), -1);
  tool_.assign(contacts.size(), -1);
  int holds = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (contacts[k].kind != Contact::Kind::kDisplacement || IsTool(contacts[k])) continue;
    if (contacts[k].radius > 0) return Fail("a round tool: expected a model at rest");
    hold_[k] = holds++;
    moved_ = places()[k].nodes;
    for (PlaceWeight& node : moved_) node.place = body_.Number(node.place);
    if (!(places()[k].is_point ? constraints_.HoldPoint(moved_) : constraints_.HoldNodes(moved_))) {
      return Fail("two contacts overlap");
    }
  }
  if (stepper_) {
    stepper_->Renew();
    return true;
  }
  equilibrium_->Renew();
  if (!constraints_.FindFreeMotions()) return Fail("more than four parts without fixed nodes");
  return !tools_ || HoldTools(contacts);
}

// Contacts that existed before keep their path.
bool FemModel::HoldTools(std::span<const Contact> contacts) {
  std::swap(accepted_, former_);
  accepted_.assign(contacts.begin(), contacts.end());
  const auto is_touchable = [&](const PlaceWeight& at) {
    const double* free = At(body_.free(), body_.Number(at.place)).v;
    return free[0] * free[1] * free[2] != 0;
  };
  std::vector<fem::ToolContacts::Touch> touches;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto known = std::ranges::find_if(
        former_, [&](const Contact& before) { return before.IsAt(contacts[k]); });
    accepted_[k].prescribed_O =
        known != former_.end() ? known->prescribed_O : Vector3d(Vector3d::Zero());
    if (!IsTool(contacts[k])) continue;
    if (std::ranges::none_of(places()[k].nodes, is_touchable)) {
      std::swap(accepted_, former_);
      return Fail("the tool touches only what supports hold");
    }
    tool_[k] = static_cast<int>(touches.size());
    const double friction = params_.contact == ContactLaw::kBonded
                                ? std::numeric_limits<double>::infinity()
                                : params_.friction;
    touches.push_back(
        {ToolAt(contacts[k]), contacts[k].p_O, contacts[k].width, contacts[k].radius, friction});
  }
  const bool is_free = !touches.empty() && constraints_.has_free_motions();
  if (!is_free && tools_->Set(touches)) return true;
  std::swap(accepted_, former_);  // the tools are those of before
  return Fail(is_free
                  ? "a tool that nodes come under and leave: expected an object that supports hold"
                  : "no surface is there");
}

bool FemModel::SolveUnder(std::span<const Contact> contacts) {
  if (tools_ && !tools_->empty()) return MoveTools(contacts);
  if (!Prescribe(contacts, 1)) return Fail("a contact moves fixed nodes");
  if (stepper_) {
    return stepper_->Step(f_ext_, constraints_) || Fail("the time step did not converge");
  }
  if (constraints_.Imbalance(f_ext_) > kBalanced) {
    return Fail("the loads do not balance on an object without fixed boundary");
  }
  if (equilibrium_->Solve(f_ext_, constraints_)) return true;
  return Fail(equilibrium_->interrupted() ? "interrupted" : "no equilibrium was found");
}

// Moves the tools in increments and accepts each, so that friction follows the path. An increment
// without equilibrium is halved. After the deadline the rest of the path is one increment, and the
// answer is flagged.
bool FemModel::MoveTools(std::span<const Contact> contacts) {
  double parts = 1;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (tool_[k] < 0) continue;
    if (IsFar(contacts[k])) return Fail(kFarTool);
    const double way = (contacts[k].prescribed_O - accepted_[k].prescribed_O).norm();
    const double edge = tools_->at(tool_[k]).edge() * traits_.length_unit;
    parts = std::max(parts, std::ceil(way / (kIncrement * edge)));
  }
  const double least = kMinIncrement / parts;
  double done = 0, part = 1 / parts;
  jumped_ = false;
  equilibrium_->Keep();
  tools_->Keep();
  kept_ = accepted_;
  equilibrium_->Begin();
  while (done < 1) {
    const bool is_last = done + part > 1 - 0.5 * least;
    jumped_ = jumped_ || (!is_last && equilibrium_->late());
    const double next = is_last || jumped_ ? 1 : done + part;
    if (!Prescribe(contacts, next)) return Fail("a contact moves fixed nodes");
    if (equilibrium_->Increment(f_ext_, constraints_, *tools_, next == 1)) {
      tools_->Accept(equilibrium_->displacement(), equilibrium_->reaction());
      done = next;
      continue;
    }
    part /= 2;
    if (!equilibrium_->interrupted() && part >= least) continue;
    TakeBack();
    return Fail(equilibrium_->interrupted() ? "interrupted" : "no equilibrium was found");
  }
  equilibrium_->End(constraints_, *tools_);
  tools_->Accept(equilibrium_->displacement(), equilibrium_->reaction());
  tools_->EstimateErrors(equilibrium_->reaction_error(), equilibrium_->displacement_error());
  for (std::size_t k = 0; k < contacts.size(); ++k) accepted_[k] = contacts[k];
  return true;
}

void FemModel::TakeBack() {
  if (stepper_) return stepper_->TakeBack();
  if (!follows_path()) return;
  equilibrium_->TakeBack();
  tools_->TakeBack();
  accepted_ = kept_;
}

// False: a contact moves a fixed node.
bool FemModel::Prescribe(std::span<const Contact> contacts, double part) {
  f_ext_ = gravity_;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    Vector3d prescribed = contacts[k].prescribed_O;
    if (part < 1) prescribed = part * prescribed + (1 - part) * accepted_[k].prescribed_O;
    if (tool_[k] >= 0) {
      tools_->Begin(tool_[k], prescribed / traits_.length_unit, equilibrium_->displacement());
      continue;
    }
    if (hold_[k] >= 0) {
      if (!constraints_.Move(hold_[k], prescribed / traits_.length_unit)) return false;
      continue;
    }
    for (const auto& [node, weight] : places()[k].nodes) {
      Eigen::Map<Vector3d>(At(f_ext_, body_.Number(node)).v) +=
          weight * prescribed / traits_.force_unit;
    }
  }
  return true;
}

VolumeModel::Inversion FemModel::FindInversion() const {
  const fem::ElementSummary& last = summary();
  return {last.inverted, last.inverted > 0 ? body_.MeshElement(last.first_inverted) : -1};
}

double FemModel::ErrorOf(std::size_t contact) const {
  if (params_.options.law != FemOptions::Law::kNeoHookean) return 0;
  if (tool_[contact] >= 0) {
    const fem::ToolContact& tool = tools_->at(tool_[contact]);
    const double path = tool.has_friction() ? equilibrium_->PathError() : 0;
    return tool.error() + path * tool.force().norm();
  }
  if (hold_[contact] >= 0) {
    return constraints_.Sum(hold_[contact], equilibrium_->reaction_error()).norm();
  }
  Vector3d moved = Vector3d::Zero();
  for (const auto& [node, weight] : places()[contact].nodes) {
    moved += weight * VectorAt(equilibrium_->displacement_error(), node);
  }
  return moved.norm();
}

double FemModel::energy() const {
  const double energy = stepper_ ? stepper_->energy() : equilibrium_->summary().energy;
  return energy * traits_.force_unit * traits_.length_unit;
}

}  // namespace palpate
