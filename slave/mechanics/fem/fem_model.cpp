#include "slave/mechanics/fem/fem_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "shared/geometry/index.h"
#include "shared/mesh/disc_patch.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using fem::At;
using fem::NodeVector;

constexpr double kLocks = 0.49;       // Poisson's ratio from which tet4 answers are far too stiff
constexpr double kLinearRange = 0.1;  // of the larger side
constexpr double kBalanced = 1e-6;    // of the loads' sizes
constexpr double kAbsurd = 1e6;       // larger sides, or E times larger side squared
constexpr int kRehearsed = 30'000;    // elements
constexpr std::size_t kTextSize = 240;

bool Dynamic(const FemOptions& options) {
  return options.time == FemOptions::Time::kDynamic;
}
bool Linear(const FemOptions& options) {
  return options.law == FemOptions::Law::kLinear;
}

void CheckOptions(const FemOptions& options) {
  if (options.element != FemOptions::Element::kTet4) {
    throw std::invalid_argument("element = tet10: accepted is tet4 in this model");
  }
  if (IsHyperelastic(options.law)) {
    throw std::invalid_argument(
        "law = neo-hookean, ogden: accepted is linear, corotational in this model");
  }
  if (options.pressure != FemOptions::Pressure::kAuto &&
      options.pressure != FemOptions::Pressure::kDisplacement) {
    throw std::invalid_argument("pressure: accepted is auto, displacement in this model");
  }
  if (!(options.residual >= 1e-14 && options.residual < 1)) {
    RefuseValue("residual", options.residual, "1e-14 <= residual < 1");
  }
  if (options.threads < 1 || options.threads > 256) {
    RefuseValue("threads", options.threads, "1 to 256");
  }
  if (!options.gravity_O.allFinite()) throw std::invalid_argument("gravity: accepted is finite");
  if (!Dynamic(options)) return;
  RequirePositive("step", options.step);
  RequireNotNegative("damping.mass", options.damping_mass);
  RequireNotNegative("damping.stiffness", options.damping_stiffness);
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

// All that can be refused is refused before the work starts.
fem::FemBody::Params BodyParams(const FemModel::Params& params, const SolidMesh& mesh,
                                Progress* progress) {
  CheckOptions(params.options);
  CheckMaterial(params.material, params.options);
  if (!(params.range >= 0)) RefuseValue("range", params.range, "0 (default) or more");
  if (progress != nullptr) {
    const auto elements = static_cast<double>(mesh.tets.size());
    progress->Expect({5e-6 * elements, static_cast<std::size_t>(1500 * elements)});
  }
  ReportProgress(progress, "numbering nodes", 0);
  return {params.material.poisson_ratio,
          Linear(params.options) ? fem::TetElements::Law::kLinear
                                 : fem::TetElements::Law::kCorotational,
          params.options.threads};
}

// Numbered and measured as the body is.
StrainResolution StrainsOf(const SolidMesh& mesh, const HeldNodes& held, const fem::FemBody& body,
                           double nu) {
  SolidMesh numbered{body.points(), mesh.tets, mesh.modulus};
  HeldNodes numbered_held(numbered.nodes.size());
  for (std::size_t i = 0; i < held.size(); ++i) {
    const int number = body.Number(static_cast<int>(i));
    if (number >= 0) numbered_held[Index(number)] = held[i];
  }
  for (auto& tet : numbered.tets) {
    for (int& node : tet) node = body.Number(node);
  }
  return {numbered, numbered_held, nu};
}

}  // namespace

FemModel::FemModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
                   Progress* progress)
    : params_(params),
      body_(mesh, held, BodyParams(params, mesh, progress)),
      length_unit_(body_.length_unit()),
      force_unit_(params.material.young_modulus * length_unit_ * length_unit_),
      time_unit_(length_unit_ * std::sqrt(params.material.density / params.material.young_modulus)),
      constraints_(body_),
      contacts_(mesh, body_),
      gravity_(Index(body_.size())),
      f_ext_(Index(body_.size())),
      strain_(StrainsOf(mesh, held, body_, params.material.poisson_ratio)),
      u_(Index(body_.size())) {
  ReportProgress(progress, "preparing the solver", 0.6);
  const FemOptions& options = params.options;
  SetGravity();
  if (Dynamic(options)) {
    stepper_.emplace(
        body_, fem::TimeStepper::Params{options.step / time_unit_, options.residual,
                                        options.damping_mass * time_unit_,
                                        options.damping_stiffness / time_unit_, Linear(options)});
  } else {
    equilibrium_.emplace(
        body_, fem::StaticEquilibrium::Params{options.residual, Linear(options), progress});
  }
  Reset();
  Describe(mesh);
  ReportProgress(progress, "first solution", 0.8);
  Rehearse(mesh);
  NotePrecompute();
  ReportProgress(progress, "ready", 1);
}

void FemModel::SetGravity() {
  const Vector3d weight = params_.material.density * params_.options.gravity_O * length_unit_ /
                          params_.material.young_modulus;
  for (int i = 0; i < body_.size(); ++i) {
    for (int c = 0; c < 3; ++c) At(gravity_, i).v[c] = body_.Volume(i) * weight[c];
  }
}

void FemModel::Describe(const SolidMesh& mesh) {
  field_mesh_ = {.vertices = mesh.nodes, .tets = mesh.tets};
  keeps_displacements_ = true;
  info_.kind = "fem";
  info_.elements = static_cast<int>(mesh.tets.size());
  for (const auto& node : body_.free()) {
    for (const double free : node.v) info_.dof += free > 0 ? 1 : 0;
  }
  info_.memory_bytes =
      body_.memory_bytes() + (stepper_ ? stepper_->memory_bytes() : equilibrium_->memory_bytes());
  info_.range = params_.range > 0 ? params_.range : Linear(params_.options) ? kLinearRange : 0;
  info_.step = stepper_ ? params_.options.step : 0;
  if (params_.material.poisson_ratio >= kLocks) {
    remark_ = "linear tetrahedra lock at this Poisson ratio: the model is far too stiff";
  }
  info_.remark.reserve(kTextSize);
  failure_text_.reserve(kTextSize);
  info_.remark = remark_;
}

// What a moved contact costs, on meshes where that is soon known.
void FemModel::Rehearse(const SolidMesh& mesh) {
  if (body_.element_count() > kRehearsed) return;
  const SurfaceMesh surface = SurfaceOf(mesh);
  if (surface.triangles.empty()) return;
  Contact contact{.kind = Contact::Kind::kForce, .p_O = Centroid(surface, 0)};
  contact.prescribed_O =
      -1e-6 * force_unit_ * Area(surface, 0) / (length_unit_ * length_unit_) * Normal(surface, 0);
  ContactResponse response;
  Respond({&contact, 1}, {&response, 1});
  contact.prescribed_O *= 2;
  const auto start = std::chrono::steady_clock::now();
  Respond({&contact, 1}, {&response, 1});
  if (response.validity != Validity::kFailed) info_.update_us = 1e6 * SecondsSince(start);
  Reset();
}

void FemModel::Reset() {
  failure_ = {};
  contacts_.Forget();
  if (stepper_) {
    stepper_->Reset();
  } else {
    equilibrium_->Reset();
  }
}

bool FemModel::Fail(const char* why, int contact) {
  std::array<char, 24> which{};
  if (contact >= 0) std::snprintf(which.data(), which.size(), "contact %d: ", contact);
  failure_text_.assign(which.data()).append(why);
  return DeformationModel::Fail(failure_text_);
}

void FemModel::ComputeResponses(std::span<const Contact> contacts,
                                std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  std::fill(responses.begin(), responses.end(), ContactResponse{});
  if (contacts.size() != responses.size()) {
    Fail("the number of responses and contacts must be equal");
    return;
  }
  bool answered = false;
  try {
    answered = TryRespond(contacts);
  } catch (const std::exception& e) {  // out of memory
    Fail(e.what());
  }
  if (!answered) return;
  RemarkInversion();
  const auto doubt = FlagReason(contacts);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    responses[k] = ResponseOf(k, contacts[k], doubt);
  }
}

bool FemModel::TryRespond(std::span<const Contact> contacts) {
  if (!Locate(contacts)) return false;
  f_ext_ = gravity_;
  if (!contacts_.Apply(contacts, length_unit_, force_unit_, constraints_, f_ext_)) {
    return Fail("a contact moves fixed nodes");
  }
  if (stepper_) {
    if (stepper_->Step(f_ext_, constraints_)) return true;
    return Fail("the time step did not converge");
  }
  if (constraints_.Imbalance(f_ext_) > kBalanced) {
    return Fail("the loads do not balance on an object without fixed boundary");
  }
  if (equilibrium_->Solve(f_ext_, constraints_)) return true;
  return Fail(equilibrium_->interrupted() ? "interrupted" : "no equilibrium was found");
}

bool FemModel::Locate(std::span<const Contact> contacts) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const bool force = contacts[k].kind == Contact::Kind::kForce;
    const double size = contacts[k].prescribed_O.norm() / (force ? force_unit_ : length_unit_);
    if (size <= kAbsurd || !std::isfinite(size)) continue;
    return Fail(force ? "the force is beyond a million times E times the larger side squared"
                      : "the displacement is beyond a million times the larger side",
                static_cast<int>(k));
  }
  const auto found = contacts_.Update(contacts, constraints_);
  if (found.refusal != nullptr) {
    contacts_.Forget();
    return Fail(found.refusal, found.contact);
  }
  if (found.change != fem::ContactSet::Change::kNone) {
    touched_.clear();
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      for (const PlaceWeight& node : contacts_.nodes(k)) touched_.push_back(node.place);
    }
  }
  if (found.change != fem::ContactSet::Change::kHolds) return true;
  if (stepper_) {
    stepper_->Renew();
    return true;
  }
  equilibrium_->Renew();
  if (constraints_.FindFreeMotions()) return true;
  contacts_.Forget();
  return Fail("more than four parts without fixed nodes");
}

// Why the last answer is extrapolated; nullopt: it is not, but for single patches.
std::optional<std::string_view> FemModel::FlagReason(std::span<const Contact> contacts) noexcept {
  if (summary().inverted > 0) return "elements are inside out";
  if (params_.material.poisson_ratio >= kLocks)
    return "linear tetrahedra lock at this Poisson ratio";
  if (info_.range > 0 && fem::LargestComponent(displacement()) > info_.range) return kBeyondRange;
  if (stepper_ && stepper_->gained_energy()) return "the time step gained energy";
  // In equilibrium under nothing, what is left of strain is the residual's.
  const bool acts = stepper_ || params_.options.gravity_O != Vector3d::Zero() ||
                    std::ranges::any_of(contacts, [](const Contact& contact) {
                      return contact.prescribed_O != Vector3d::Zero();
                    });
  if (acts && Softness() > kMostSoftness) return kStiffInBending;
  return std::nullopt;
}

double FemModel::Softness() noexcept {
  for (std::size_t i = 0; i < u_.size(); ++i) {
    const double* u = displacement()[i].v;
    u_[i] = {u[0], u[1], u[2]};
  }
  return strain_.Softness(u_, touched_);
}

void FemModel::RemarkInversion() {
  if (summary().inverted == 0) {
    info_.remark.assign(remark_);
    return;
  }
  std::array<char, kTextSize> text{};
  std::snprintf(text.data(), text.size(), "%d elements are inside out, the first is %d%s%s",
                summary().inverted, body_.MeshElement(summary().first_inverted),
                remark_.empty() ? "" : "; ", remark_.c_str());
  info_.remark.assign(text.data());
}

ContactResponse FemModel::ResponseOf(std::size_t k, const Contact& contact,
                                     std::optional<std::string_view> doubt) const noexcept {
  ContactResponse response;
  if (!doubt && contacts_.coarse(k)) doubt = kCoarsePatch;
  if (!doubt && contacts_.on_support(k)) doubt = kOnSupport;
  response.validity = doubt ? Validity::kExtrapolated : Validity::kValid;
  response.doubt = doubt.value_or(std::string_view());
  const int hold = contacts_.hold(k);
  if (hold >= 0) {
    const auto& reaction = stepper_ ? stepper_->reaction() : equilibrium_->reaction();
    response.force_O = force_unit_ * constraints_.Sum(hold, reaction);
    response.displacement_O = contact.prescribed_O;
    SetMoment(
        contacts_.arms(k), contact.width,
        [&](std::size_t i) -> Vector3d {
          const double* force = At(reaction, contacts_.nodes(k)[i].place).v;
          return force_unit_ * Vector3d(force[0], force[1], force[2]);
        },
        &response);
  } else {
    response.force_O = contact.prescribed_O;
    response.displacement_O = length_unit_ * contacts_.Mean(k, displacement());
    SetMoment(
        contacts_.arms(k), contact.width,
        [&](std::size_t i) -> Vector3d {
          return contacts_.nodes(k)[i].weight * contact.prescribed_O;
        },
        &response);
  }
  return response;
}

void FemModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  u_O->resize(displacement().size());
  for (std::size_t i = 0; i < u_O->size(); ++i) {
    const double* u = At(displacement(), body_.Number(static_cast<int>(i))).v;
    (*u_O)[i] = length_unit_ * Vector3d(u[0], u[1], u[2]);
  }
}

double FemModel::energy() const {
  const double energy = stepper_ ? stepper_->energy() : equilibrium_->summary().energy;
  return energy * force_unit_ * length_unit_;
}

}  // namespace palpate
