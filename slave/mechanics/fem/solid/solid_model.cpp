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
using Element = FemOptions::Element;
using Law = FemOptions::Law;
using Pressure = FemOptions::Pressure;
using Time = FemOptions::Time;

constexpr double kAbsurd = 1e6;          // larger sides
constexpr double kAutoMixed = 0.49;      // nu from which ten nodes take a pressure
constexpr double kBalanced = 1e-6;       // work of loads on free motions over all work
constexpr double kStillBalanced = 1e-3;  // force on pins over loads, once deformed
constexpr double kLeastPart = 1.0 / 64;  // of a load that is applied at once
constexpr int kMostSteps = 300;          // of Newton's method for one answer, all parts together
constexpr double kGrowth = 1e-6;         // of energy, per step, that rounding explains
constexpr double kLooseGrowth = 1e-2;    // where the step is not a minimum of energy

double SideOf(const SolidMesh& mesh) {
  const double side = LargerSide(mesh.nodes);
  if (side > 0 && std::isfinite(side)) return side;
  throw std::invalid_argument("mesh: accepted is a finite extent > 0");
}

bool TakesPressure(const SolidModel::Params& params) {
  const auto& o = params.options;
  if (o.pressure != Pressure::kAuto) return o.pressure != Pressure::kDisplacement;
  return o.element == Element::kTet10 && params.poisson_ratio >= kAutoMixed;
}

void CheckPressure(const SolidModel::Params& params) {
  const auto& o = params.options;
  const double nu = params.poisson_ratio;
  if (o.pressure == Pressure::kMixed && o.element != Element::kTet10) {
    throw std::invalid_argument(
        "pressure = mixed: accepted with element = tet10; tet4 takes averaged");
  }
  if (o.pressure == Pressure::kAveraged && o.element != Element::kTet4) {
    throw std::invalid_argument(
        "pressure = averaged: accepted with element = tet4; tet10 takes mixed");
  }
  if (!TakesPressure(params)) {
    if (nu <= SolidModel::kNearlyIncompressible) return;
    RefuseValue("poisson_ratio", nu,
                "at most 0.49999 without a pressure unknown (tet10 with mixed)");
  }
  if (nu <= 0 && !IsHyperelastic(o.law)) {
    RefuseValue("poisson_ratio", nu, "> 0 with pressure = mixed or averaged");
  }
  if (o.element == Element::kTet4 && nu > SolidModel::kAveragedLimit) {
    RefuseValue("poisson_ratio", nu, "at most 0.4999 with pressure = averaged");
  }
  if (o.law != Law::kLinear && nu > SolidModel::kNearlyIncompressible) {
    RefuseValue("poisson_ratio", nu, "at most 0.49999 unless law = linear");
  }
  if (o.time == Time::kDynamic && o.damping_stiffness > 0) {
    RefuseValue("damping.stiffness", o.damping_stiffness, "0 with pressure = mixed or averaged");
  }
}

SolidModel::Params Checked(const SolidModel::Params& params) {
  const auto& o = params.options;
  RequirePositive("young_modulus", params.young_modulus);
  RequirePositive("range", params.range);
  RequirePositive("residual", o.residual);
  if (o.residual > 0.1) RefuseValue("residual", o.residual, "at most 0.1");
  if (!(params.poisson_ratio > -1 && params.poisson_ratio <= 0.5)) {
    RefuseValue("poisson_ratio", params.poisson_ratio, "-1 < nu <= 0.5");
  }
  if (!o.gravity_O.allFinite()) throw std::invalid_argument("gravity: accepted is finite");
  if (o.time == Time::kDynamic || !o.gravity_O.isZero(0))
    RequirePositive("density", params.density);
  if (o.time == Time::kDynamic) {
    RequirePositive("step", o.step);
    RequireNotNegative("damping.mass", o.damping_mass);
    RequireNotNegative("damping.stiffness", o.damping_stiffness);
    if (o.newton < 0) RefuseValue("newton", o.newton, ">= 0");
  }
  CheckPressure(params);
  return params;
}

Equilibrium::Options SolverOptions(const SolidModel::Params& params) {
  const auto& o = params.options;
  Equilibrium::Options options;
  options.residual = o.residual;
  options.limits = params.limits;
  if (o.time == Time::kDynamic) {
    options.linear_solves = o.newton;
    options.warped = o.newton > 0 && o.tangent == FemOptions::Tangent::kWarped;
  }
  return options;
}

// Rough, before anything is built: factors of three-dimensional meshes grow like n^(4/3).
void Announce(const SolidMesh& mesh, const SolidModel::Params& params, Progress* progress) {
  if (!progress) return;
  const bool quadratic = params.options.element == Element::kTet10;
  const double nodes = static_cast<double>(mesh.nodes.size()) * (quadratic ? 7.5 : 1);
  const double entries = std::min(30 * std::pow(3 * nodes, 4.0 / 3), 1.8e8);
  const double matrix = 3 * nodes * (quadratic ? 45 : 25);
  progress->Expect({1e-5 * static_cast<double>(mesh.tets.size()) * (quadratic ? 4 : 1) +
                        entries * std::sqrt(entries) * 2e-10,
                    static_cast<std::size_t>(12 * (entries + 5 * matrix))});
  ReportProgress(progress, "mesh and pattern", 0);
}

}  // namespace

SolidModel::SolidModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
                       Progress* progress)
    : params_((Announce(mesh, params, progress), Checked(params))),
      unit_((RequireOnePerNode(held, mesh), SideOf(mesh))),
      mesh_(MakeElementMesh(mesh, params_.options.element, unit_)),
      layout_((ReportProgress(progress, "mesh and pattern", 0.3), mesh_), TakesPressure(params_)),
      body_(mesh_, layout_,
            MaterialLaw(params_.options.law, params_.poisson_ratio, params_.options.terms)),
      equilibrium_((ReportProgress(progress, "mesh and pattern", 0.6), layout_), body_,
                   SolverOptions(params_)),
      used_(Index(mesh_.node_count()), false),
      contacts_(mesh_, used_, unit_),
      supports_(mesh_, layout_, held, body_.NodeVolumes()) {
  field_mesh_ = {.vertices = mesh.nodes, .tets = mesh.tets};
  if (mesh_.nodes_per_element == 4) {
    // Of bending alone where the pressure is the elements' own.
    strain_.emplace(SolidMesh{mesh_.nodes, mesh.tets}, held,
                    layout_.has_pressure() ? 0.0 : params_.poisson_ratio);
    u_.resize(mesh_.nodes.size());
  }
  for (const int node : mesh_.connectivity) used_[Index(node)] = true;
  if (layout_.has_pressure() && !equilibrium_.solver().is_direct()) {
    throw std::invalid_argument(
        "pressure = mixed or averaged: accepted while the factorisation fits in memory; this mesh "
        "needs " +
        std::to_string(equilibrium_.solver().memory_bytes() >> 20U) + " MiB: use a coarser mesh");
  }
  const auto& o = params_.options;
  const VectorXd zero = VectorXd::Zero(layout_.size());
  weight_ = target_ = loads_ = x_ = start_ = good_ = start_loads_ = zero;
  balance_.force = balance_.given = zero;
  const VectorXd volumes = body_.NodeVolumes();
  const Vector3d pull = params_.density * unit_ / params_.young_modulus * o.gravity_O;
  for (int node = 0; node < mesh_.node_count(); ++node) {
    weight_.segment<3>(layout_.first(node)) = volumes[node] * pull;
  }
  if (dynamic()) {
    velocity_ = start_velocity_ = start_forces_ = product_ = zero;
    mass_ = damping_ = inertia_ = layout_.pattern();
    body_.AddMass(params_.density * unit_ * unit_ / params_.young_modulus,
                  o.mass == FemOptions::Mass::kLumped, &mass_);
    balance_.inertia = &inertia_;
    balance_.origin = &start_;
  }
  Reset();
  ReportProgress(progress, "mesh and pattern", 1);
  Describe(progress);
}

// Factors once where that is what an answer costs least, and measures it.
void SolidModel::Describe(Progress* progress) {
  keeps_displacements_ = true;
  info_.kind = IsHyperelastic(params_.options.law) ? "fem-hyperelastic" : "fem";
  info_.dof = static_cast<std::size_t>(layout_.size());
  info_.elements = mesh_.element_count();
  info_.range = params_.options.law == Law::kLinear ? params_.range : 0;
  info_.step = dynamic() ? params_.options.step : 0;
  ReportProgress(progress, "first solution", 0);
  const auto before = std::chrono::steady_clock::now();
  if (params_.options.law == Law::kLinear && !dynamic()) {
    Respond({}, {});
    info_.update_us = 1e6 * SecondsSince(before);
  }
  const SymmetricSolver& solver = equilibrium_.solver();
  failure_ = {};
  Reset();
  info_.memory_bytes =
      solver.memory_bytes() +
      static_cast<std::size_t>(layout_.pattern().nonZeros()) * 12 * (dynamic() ? 6 : 3) +
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
  x_.setZero();
  inverted_ = false;
  start_loads_.setZero();
  row_start_.assign(row_start_.size(), 0);
  balance_.row_force.setZero();
  if (dynamic()) {
    velocity_.setZero();
    start_forces_ = weight_;
    step_ready_ = false;
  }
}

void SolidModel::Start(std::span<const Contact> contacts) {
  if (!dynamic() || !Acceptable(contacts)) return;
  if (PrepareSet(contacts) && Prescribe(contacts)) start_forces_ = loads_;
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
  if (!(dynamic() ? SolveStep() : SolveStatic())) {
    if (failure_.empty()) failure_ = equilibrium_.failure();
    return false;
  }
  return Fill(contacts, responses);
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
  if (!contacts_.changed() && !balance_.fixed.empty()) return true;
  equilibrium_.Changed();
  supports_.Hold(&balance_);
  balance_.rows.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].kind != Contact::Kind::kDisplacement) continue;
    const ContactPlace& place = contacts_.places()[i];
    for (const int node : place.moved) {
      for (int c = 0; c < 3; ++c) balance_.fixed[Index(layout_.first(node) + c)] = 1;
    }
    for (int c = 0; place.moved.empty() && c < 3; ++c) {
      PointRow row;
      for (const auto& [node, weight] : place.weights) {
        row.weights.emplace_back(layout_.first(node) + c, weight);
      }
      balance_.rows.push_back(std::move(row));
    }
  }
  balance_.row_force.setZero(static_cast<int>(balance_.rows.size()));
  row_target_.assign(balance_.rows.size(), 0);
  if (!dynamic()) supports_.Pin(&balance_);
  return true;
}

bool SolidModel::Prescribe(std::span<const Contact> contacts) {
  target_.setZero();
  loads_ = weight_;
  std::size_t row = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactPlace& place = contacts_.places()[i];
    if (contacts[i].kind == Contact::Kind::kForce) {
      const Vector3d force = contacts[i].prescribed_O / (params_.young_modulus * unit_ * unit_);
      for (const auto& [node, share] : place.weights) {
        loads_.segment<3>(layout_.first(node)) += share * force;
      }
      continue;
    }
    const Vector3d moved = contacts[i].prescribed_O / unit_;
    for (const int node : place.moved) {
      if (supports_.Forbids(node, moved)) return Fail("a fixed node is moved");
      target_.segment<3>(layout_.first(node)) = moved;
    }
    for (int c = 0; place.moved.empty() && c < 3; ++c) row_target_[row++] = moved[c];
  }
  return true;
}

bool SolidModel::CheckFreeBody() {
  if (!supports_.is_free() || supports_.Imbalance(loads_) <= kBalanced) return true;
  return Fail("loads on a body that is free to move do not balance");
}

bool SolidModel::SolveStatic() {
  if (!CheckFreeBody()) return false;
  if (inverted_ && params_.options.law != Law::kLinear) Reset();  // such states may be traps
  start_ = x_;
  newton_steps_ = 0;
  if (!SolveInParts()) {
    if (params_.options.law == Law::kLinear || start_.isZero(0)) return false;
    newton_steps_ = 0;
    Reset();  // from rest instead of from the last answer
    start_ = x_;
    if (!SolveInParts()) return false;
  }
  start_loads_ = loads_;
  row_start_ = row_target_;
  if (!supports_.is_free()) return true;
  if (supports_.PinForce(equilibrium_.unbalanced()) > kStillBalanced * loads_.norm()) {
    return Fail("loads on a body that is free to move do not balance once it has deformed");
  }
  supports_.RemoveFreeMotion(&x_);
  return true;
}

// All at once if Newton's method takes it, else in parts that are halved until it does.
bool SolidModel::SolveInParts() {
  good_ = start_;
  double done = 0, part = 1;
  while (done < 1) {
    const double t = std::min(1.0, done + part);
    balance_.force = (1 - t) * start_loads_ + t * loads_;
    for (int i = 0; i < x_.size(); ++i) {
      if (balance_.fixed[Index(i)]) balance_.given[i] = (1 - t) * start_[i] + t * target_[i];
    }
    for (std::size_t k = 0; k < balance_.rows.size(); ++k) {
      double from = 0;
      for (const auto& [unknown, weight] : balance_.rows[k].weights) {
        from += weight * start_[unknown];
      }
      balance_.rows[k].value = (1 - t) * from + t * row_target_[k];
    }
    x_ = good_;
    const bool solved = equilibrium_.Solve(&balance_, &x_);
    newton_steps_ += equilibrium_.newton_steps();
    if (solved) {
      good_ = x_;
      done = t;
      part *= 2;
      continue;
    }
    part /= 2;
    if (part < kLeastPart || newton_steps_ > kMostSteps || params_.options.law == Law::kLinear) {
      return false;
    }
  }
  return true;
}

// Q = c_m M + c_d D and its share of the load, from the state at the start of the step:
// implicit Euler and Newmark's average acceleration (beta = 1/4, gamma = 1/2).
void SolidModel::PrepareStep() {
  const auto& o = params_.options;
  const double h = o.step;
  const double c_m = (newmark() ? 4 : 1) / (h * h), c_d = (newmark() ? 2 : 1) / h;
  const bool constant = params_.options.law == Law::kLinear || o.damping_stiffness == 0;
  if (!step_ready_ || !constant) {
    const auto n = layout_.pattern().nonZeros();
    const auto values = [&](SparseMatrix& m) { return Eigen::Map<VectorXd>(m.valuePtr(), n); };
    if (o.damping_stiffness > 0) {
      equilibrium_.Stiffness(x_, &damping_);
    } else {
      values(damping_).setZero();
    }
    values(damping_) = o.damping_stiffness * values(damping_) + o.damping_mass * values(mass_);
    values(inertia_) = c_m * values(mass_) + c_d * values(damping_);
    step_ready_ = true;
  }
  start_ = x_;
  start_velocity_ = velocity_;
  Multiply(mass_, velocity_, &product_);
  balance_.force = loads_ + c_m * h * product_;
  if (!newmark()) return;
  Multiply(damping_, velocity_, &product_);
  balance_.force += product_ + start_forces_;
}

bool SolidModel::SolveStep() {
  const bool checks_energy = params_.options.law != Law::kLinear;
  if (checks_energy) start_energy_ = total_energy_nondimensional();
  PrepareStep();
  balance_.given = target_;
  for (std::size_t k = 0; k < balance_.rows.size(); ++k) balance_.rows[k].value = row_target_[k];
  if (!equilibrium_.Solve(&balance_, &x_)) return false;
  newton_steps_ = equilibrium_.newton_steps();
  FinishStep();
  grew_ = checks_energy && EnergyGrew();
  return true;
}

void SolidModel::FinishStep() {
  const double h = params_.options.step;
  if (!newmark()) {
    velocity_ = (x_ - start_) / h;
    return;
  }
  velocity_ = 2 / h * (x_ - start_) - start_velocity_;
  good_ = velocity_ - start_velocity_;
  Multiply(mass_, good_, &product_);
  start_forces_ = 2 / h * product_ - start_forces_;
}

double SolidModel::total_energy_nondimensional() {
  Multiply(mass_, velocity_, &product_);
  return equilibrium_.Energy(x_) + 0.5 * velocity_.dot(product_);
}

// Energy the step made of nothing: more than loads and moved nodes gave.
bool SolidModel::EnergyGrew() {
  const double energy = total_energy_nondimensional();
  double work = 0, given = 0;
  for (int i = 0; i < x_.size(); ++i) {
    const double moved = x_[i] - start_[i];
    const double carried = balance_.fixed[Index(i)] ? equilibrium_.unbalanced()[i] : 0;
    work += (loads_[i] + carried) * moved;
    given += std::abs((loads_[i] + carried) * moved);
  }
  for (std::size_t k = 0; k < balance_.rows.size(); ++k) {
    for (const auto& [unknown, weight] : balance_.rows[k].weights) {
      const double part =
          balance_.row_force[static_cast<int>(k)] * weight * (x_[unknown] - start_[unknown]);
      work += part;
      given += std::abs(part);
    }
  }
  const bool minimum = params_.options.newton == 0 && !newmark();
  const double slack = minimum ? std::max(kGrowth, params_.options.residual) : kLooseGrowth;
  return energy - start_energy_ - work > slack * (start_energy_ + given);
}

// Of the tool on the object, nondimensional: what moved nodes lack.
Vector3d SolidModel::ForceOn(const ContactPlace& place) const {
  Vector3d force = Vector3d::Zero();
  for (const int node : place.moved) {
    force += equilibrium_.unbalanced().segment<3>(layout_.first(node));
  }
  return force;
}

// Why the answer is extrapolated; nullopt: it is not, but for single patches.
std::optional<std::string_view> SolidModel::FlagReason(double largest) {
  if (inverted_) return "elements are inside out";
  if (locks()) return "linear tetrahedra lock at this Poisson ratio";
  if (params_.options.law == Law::kLinear && largest > params_.range) return kBeyondRange;
  if (dynamic() && grew_) return "the time step gained energy";
  // In equilibrium under nothing, what is left of strain is the residual's.
  const bool acts = dynamic() || !loads_.isZero(0) || !target_.isZero(0) ||
                    std::ranges::any_of(row_target_, [](double moved) { return moved != 0; });
  if (strain_ && acts && Softness() > kMostSoftness) return kStiffInBending;
  return std::nullopt;
}

double SolidModel::Softness() {
  touched_.clear();
  for (const ContactPlace& place : contacts_.places()) {
    for (const int node : place.moved) touched_.push_back(node);
    for (const auto& [node, weight] : place.weights) touched_.push_back(node);
  }
  for (std::size_t i = 0; i < u_.size(); ++i) {
    u_[i] = x_.segment<3>(layout_.first(static_cast<int>(i)));
  }
  return strain_->Softness(u_, touched_);
}

bool SolidModel::Fill(std::span<const Contact> contacts, std::span<ContactResponse> responses) {
  double largest = 0;
  for (int node = 0; node < mesh_.node_count(); ++node) {
    largest = std::max(largest, x_.segment<3>(layout_.first(node)).stableNorm());
  }
  if (!(largest <= kAbsurd)) return Fail("the solution is too large");
  inverted_ = !(body_.SmallestJacobian(x_) > 0);
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
        mean += share * x_.segment<3>(layout_.first(node));
      }
      response.displacement_O = unit_ * mean;
    } else {
      response.displacement_O = contacts[i].prescribed_O;
      if (place.moved.empty()) {
        response.force_O = force_unit * balance_.row_force.segment<3>(row);
        row += 3;
      } else {
        response.force_O = force_unit * ForceOn(place);
      }
    }
    if (!response.force_O.allFinite() || !response.displacement_O.allFinite()) {
      return Fail("the solution is not finite");
    }
    responses[i] = response;
  }
  return true;
}

void SolidModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  u_O->clear();
  for (int node = 0; node < mesh_.vertex_count; ++node) u_O->push_back(displacement(node));
}

double SolidModel::total_energy() {
  if (!dynamic()) return elastic_energy();
  return params_.young_modulus * unit_ * unit_ * unit_ * total_energy_nondimensional();
}

}  // namespace palpate
