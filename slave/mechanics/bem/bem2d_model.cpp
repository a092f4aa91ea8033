#include "slave/mechanics/bem/bem2d_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include <Eigen/Geometry>

#include "shared/geometry/index.h"
#include "shared/mesh/boundary_patch.h"
#include "shared/text/text.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kAbsurd = 1e6;    // larger sides
constexpr int kMeasurements = 20;  // of an update
constexpr double kMostOff = 0.1;   // of the stiffness
// Error of the compliance [-]. [derived: the accepted 5 %, less a fifth of it because the estimate
// is the beginning of a series]
constexpr double kMostMissing = 0.04;
// Error of the moment by force times width over the number of elements of the patch [-]. [tuned:
// contact_moment_test]
constexpr double kSpreadByElements = 0.1;

Bem2dModel::Params Checked(const Bem2dModel::Params& params, const ReferenceProblem& problem,
                           Progress* progress) {
  RequirePositive("young_modulus", params.young_modulus);
  RequirePositive("thickness", params.thickness);
  RequirePositive("range", params.range);
  if (progress != nullptr) {
    progress->Expect(GreensFunctions::Estimate(problem.mesh.size(), problem.order));
  }
  return params;
}

// What a patch takes of a displacement or force: without friction its part along the normal.
Vector2d OnPatch(const ContactPatch& patch, const Vector2d& value) {
  if (patch.law != ContactPatch::Law::kFrictionless) return value;
  return patch.direction.dot(value) * patch.direction;
}

double LargerSideOf(const BoundaryMesh& mesh) {
  Eigen::AlignedBox2d box;
  for (const auto& e : mesh.elements) box.extend(e.a);
  return box.sizes().maxCoeff();
}

}  // namespace

Bem2dModel::Bem2dModel(ReferenceProblem problem, const Params& params, Progress* progress)
    : params_(Checked(params, problem, progress)),
      greens_(std::move(problem), progress),
      solver_(greens_),
      moving_(greens_),
      probe_forces_(greens_.error().probes()) {
  const BoundaryMesh& mesh = greens_.problem().mesh;
  larger_side_ = LargerSideOf(mesh);
  length_unit_ = mesh.length_unit;
  force_unit_ = params_.young_modulus * length_unit_ * params_.thickness;
  for (int i = 0; i < mesh.size(); ++i) {
    const Vector2d& a = mesh.elements[Index(i)].a;
    field_mesh_.vertices.emplace_back(a.x(), a.y(), 0);
    field_mesh_.lines.push_back({i, mesh.Next(i)});
  }
  info_.kind = "bem2d";
  info_.dof = 2 * Index(greens_.size());
  info_.elements = mesh.size();
  info_.memory_bytes = greens_.memory_bytes();
  info_.condition = greens_.condition();
  info_.range = params_.range;
  NotePrecompute();
  MeasureUpdate();
}

// One contact on two elements that nothing holds, in turn; the fastest, as others may be at work.
void Bem2dModel::MeasureUpdate() {
  std::vector<int> free;
  for (int i = 0; i < greens_.size() && free.size() < 2; i += greens_.element_nodes().count) {
    if (!greens_.held(i, 0) && !greens_.held(i, 1)) free.push_back(greens_.node(i).element);
  }
  if (free.size() < 2) return;
  Contact contact;
  ContactResponse response;
  double fastest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kMeasurements; ++k) {
    contact.element = free[Index(k % 2)];
    const auto start = std::chrono::steady_clock::now();
    Respond({&contact, 1}, {&response, 1});
    fastest = std::min(fastest, 1e6 * SecondsSince(start));
  }
  if (answered_) info_.update_us = fastest;
  prepared_ = answered_ = false;
  failure_ = {};
}

void Bem2dModel::ComputeResponses(std::span<const Contact> contacts,
                                  std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  try {
    answered_ = responses.size() == contacts.size() && TryRespond(contacts, responses);
  } catch (const std::bad_alloc&) {
    answered_ = prepared_ = Fail("out of memory");
    moving_.Forget();
  }
  if (!answered_) std::ranges::fill(responses, ContactResponse{});
}

bool Bem2dModel::TryRespond(std::span<const Contact> contacts,
                            std::span<ContactResponse> responses) {
  for (const auto& contact : contacts) {
    if (Acceptable(contact)) continue;
    return Fail("a value is not finite, out of the plane or too large");
  }
  if (!SameSet(contacts) && !PrepareSet(contacts)) return false;
  prescribed_.resize(2 * contacts.size());
  answer_.resize(2 * contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const bool moved = contacts[i].kind == Contact::Kind::kDisplacement;
    const double unit = moved ? length_unit_ : force_unit_;
    const Vector2d value = OnPatch(patches_[i], contacts[i].prescribed_O.head<2>());
    prescribed_[2 * i] = value.x() / unit;
    prescribed_[2 * i + 1] = value.y() / unit;
  }
  if (!AnswerPrescribed()) {
    return Fail(MovesWhatIsHeld() ? "an element that the scene fixes is moved or loaded"
                                  : "loads on a body that is free to move do not balance");
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    responses[i] = ResponseOf(contacts[i], static_cast<int>(i));
    if (responses[i].validity == Validity::kFailed) {
      return Fail("the solution is not finite or too large");
    }
  }
  if (IsFalsified(responses)) {
    for (ContactResponse& response : responses) {
      response.validity = Validity::kExtrapolated;
      response.doubt = kCoarseElements;
    }
  }
  return true;
}

bool Bem2dModel::IsFalsified(std::span<const ContactResponse> responses) noexcept {
  const ElementError& error = greens_.error();
  if (error.probes() == 0) return false;
  std::ranges::fill(probe_forces_, Vector2d(0, 0));
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const double share = 1 / (force_unit_ * static_cast<double>(elements_[i].size()));
    for (const int element : elements_[i]) {
      probe_forces_[Index(error.ProbeOf(element))] += share * responses[i].force_O.head<2>();
    }
  }
  return error.MissingPart(probe_forces_) > kMostMissing;
}

// Finite, planar, and not absurdly large: 1e300 m is a fault, not a displacement.
bool Bem2dModel::Acceptable(const Contact& contact) const noexcept {
  const bool moved = contact.kind == Contact::Kind::kDisplacement;
  const double largest = kAbsurd * (moved ? larger_side_ : force_unit_);
  const auto& value = contact.prescribed_O;
  return std::abs(value.x()) <= largest && std::abs(value.y()) <= largest && value.z() == 0 &&
         contact.width >= 0 && std::isfinite(contact.width) && contact.p_O.allFinite() &&
         contact.element >= -1 && contact.element < info_.elements;
}

bool Bem2dModel::SameSet(std::span<const Contact> contacts) const noexcept {
  if (!prepared_ || set_.size() != contacts.size()) return false;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    const Key& key = set_[i];
    if (key.kind != contact.kind || key.element != contact.element || key.width != contact.width) {
      return false;
    }
    const bool place_matters = contact.element < 0 || contact.width > 0;
    if (place_matters && key.p_O != contact.p_O.head<2>()) return false;
  }
  return true;
}

bool Bem2dModel::PrepareSet(std::span<const Contact> contacts) {
  prepared_ = false;
  set_.clear();
  patches_.clear();
  if (elements_.size() < contacts.size()) {
    elements_.resize(contacts.size());
    nodes_.resize(contacts.size());
  }
  for (const auto& contact : contacts) {
    if (!AppendPatch(contact)) return Fail("no element at a contact point");
    set_.push_back({contact.kind, contact.element, contact.width, contact.p_O.head<2>()});
  }
  moving_knows_ = moving_.Prepare(patches_);
  prepared_ = moving_knows_ || solver_.Prepare(patches_);
  return prepared_ || Fail(
                          "a contact shares an element with another contact or a load, or a body "
                          "without fixed boundary remains free to move, or displacements are "
                          "prescribed on the whole boundary of an incompressible body");
}

bool Bem2dModel::AnswerPrescribed() noexcept {
  if (!moving_knows_) return solver_.Respond(prescribed_, answer_);
  moving_.Respond(prescribed_, answer_);
  return true;
}

bool Bem2dModel::MovesWhatIsHeld() const noexcept {
  for (std::size_t v = 0; v < prescribed_.size(); ++v) {
    if (prescribed_[v] != 0 && solver_.blocked(static_cast<int>(v / 2), static_cast<int>(v % 2))) {
      return true;
    }
  }
  return false;
}

bool Bem2dModel::AppendPatch(const Contact& contact) {
  const BoundaryMesh& mesh = greens_.problem().mesh;
  auto& elements = elements_[patches_.size()];
  const int element =
      contact.element >= 0 ? contact.element : FindElement(mesh, contact.p_O.head<2>());
  if (element < 0) return false;
  elements.assign(1, element);
  if (contact.width > 0) {
    elements.resize(elements.capacity());
    const Vector2d place = contact.p_O.head<2>();
    auto count = Index(PatchElements(mesh, element, place, contact.width, elements));
    if (count > elements.size()) {
      elements.resize(count);
      PatchElements(mesh, element, place, contact.width, elements);
    }
    elements.resize(count);
  }
  ContactPatch patch;
  patch.nodes = NodesOf(elements, &nodes_[patches_.size()]);
  if (contact.kind == Contact::Kind::kForce) {
    patch.law = ContactPatch::Law::kLoad;
  } else if (params_.contact == ContactLaw::kFrictionless) {
    patch.law = ContactPatch::Law::kFrictionless;
    patch.direction = mesh.elements[Index(element)].normal();
  }
  patches_.push_back(patch);
  return true;
}

// All nodes of the elements; constant elements are their own.
std::span<const int> Bem2dModel::NodesOf(const std::vector<int>& elements,
                                         std::vector<int>* nodes) const {
  const int count = greens_.element_nodes().count;
  if (count == 1) return elements;
  nodes->clear();
  for (const int element : elements) {
    for (int m = 0; m < count; ++m) nodes->push_back(element * count + m);
  }
  return *nodes;
}

ContactResponse Bem2dModel::ResponseOf(const Contact& contact, int patch) noexcept {
  const auto first = 2 * Index(patch);
  Eigen::Vector3d answer(0, 0, 0);
  answer.head<2>() = OnPatch(patches_[Index(patch)], {answer_[first], answer_[first + 1]});
  ContactResponse response;
  response.force_O = contact.prescribed_O;
  response.displacement_O = contact.prescribed_O;
  if (contact.kind == Contact::Kind::kDisplacement) {
    response.force_O = force_unit_ * answer;
  } else {
    response.displacement_O = length_unit_ * answer;
  }
  if (contact.wants_stiffness) {
    response.stiffness_O.topLeftCorner<2, 2>() = StiffnessOf(contact, patch);
  }
  const double deflection = response.displacement_O.stableNorm() / larger_side_;
  const bool known =
      response.force_O.allFinite() && response.stiffness_O.allFinite() && deflection <= kAbsurd;
  if (!known) return {};
  const bool coarse = IsPatchCoarse(contact, patch);
  const bool is_valid = deflection <= params_.range && !coarse;
  response.validity = is_valid ? Validity::kValid : Validity::kExtrapolated;
  if (coarse) response.doubt = kCoarsePatch;
  SetMomentOf(contact, patch, &response);
  return response;
}

std::optional<double> Bem2dModel::OffCentre(const Contact& contact, int patch) const noexcept {
  const BoundaryMesh& mesh = greens_.problem().mesh;
  const Vector2d place = contact.p_O.head<2>();
  const int own = contact.element >= 0 ? contact.element : FindElement(mesh, place);
  std::optional<double> before;
  double length = 0;
  for (const int e : elements_[Index(patch)]) {
    const BoundaryElement& element = mesh.elements[Index(e)];
    if (e == own) {
      const Vector2d along = (element.b - element.a).normalized();
      before = length + std::clamp(along.dot(place - element.a), 0.0, element.length());
    }
    length += element.length();
  }
  if (!before) return std::nullopt;
  return *before - length / 2;
}

// As if the patch, which is of whole elements, were centred at the contact's place.
void Bem2dModel::SetMomentOf(const Contact& contact, int patch,
                             ContactResponse* response) const noexcept {
  if (contact.width == 0 || moving_knows_ || solver_.blocked(patch, 0) || solver_.blocked(patch, 1))
    return;
  const auto nodes = patches_[Index(patch)].nodes.size();
  const auto off = OffCentre(contact, patch);
  if (nodes < 2 || !off) return;
  const BoundaryMesh& mesh = greens_.problem().mesh;
  const int own = contact.element >= 0 ? contact.element : FindElement(mesh, contact.p_O.head<2>());
  const BoundaryElement& element = mesh.elements[Index(own)];
  const Vector2d centre = contact.p_O.head<2>() - *off * (element.b - element.a).normalized();
  double moment = 0;
  solver_.ForEachForce(prescribed_, patch, [&](int node, const Vector2d& force) {
    const Vector2d arm = greens_.node(node).p_O - centre;
    moment += arm.x() * force.y() - arm.y() * force.x();
  });
  response->moment_O = Eigen::Vector3d(0, 0, force_unit_ * moment);
  response->moment_sigma = kSpreadByElements * contact.width /
                           static_cast<double>(elements_[Index(patch)].size()) *
                           response->force_O.norm();
}

// A strip on a plane body gives way by 2 / (pi E t) ln(c L / width), L its larger side: c is 3.3
// for the block of paper A, measured from its stiffness, and hardly counts.
bool Bem2dModel::IsPatchCoarse(const Contact& contact, int patch) const noexcept {
  constexpr double kBody = 3.3;
  if (contact.width == 0) return false;
  double length = 0;
  for (const int e : elements_[Index(patch)]) {
    length += greens_.problem().mesh.elements[Index(e)].length();
  }
  const double lacking = std::abs(std::log(length / contact.width));
  return lacking > kMostOff * std::max(1.0, std::log(kBody * larger_side_ / length));
}

// Components that the reference problem holds cannot move: no stiffness is known for them.
Matrix2d Bem2dModel::StiffnessOf(const Contact& contact, int patch) noexcept {
  const double unit = force_unit_ / length_unit_;
  if (moving_knows_) return unit * moving_.Derivative(patch);
  Matrix2d derivative = solver_.Derivative(patch);
  const bool load = contact.kind == Contact::Kind::kForce;
  for (int c = 0; c < 2; ++c) {
    if (!solver_.blocked(patch, c)) continue;
    derivative.row(c).setZero();
    derivative.col(c).setZero();
    if (load) derivative(c, c) = 1;  // keeps the inverse of the other component
  }
  if (load) derivative = derivative.inverse().eval();
  for (int c = 0; c < 2; ++c) {
    if (load && solver_.blocked(patch, c)) derivative(c, c) = 0;
  }
  return unit * derivative;
}

void Bem2dModel::ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) {
  const BoundaryState state = Shown();
  const ElementNodes& local = greens_.element_nodes();
  const auto nodes = Index(local.count);
  const auto at_end = [&](std::size_t element, double s) {
    Vector2d u = Vector2d::Zero();
    for (std::size_t m = 0; m < nodes; ++m) {
      u += local.At(m, s) * state.displacement[element * nodes + m];
    }
    return u;
  };
  const BoundaryMesh& mesh = greens_.problem().mesh;
  u_O->assign(mesh.elements.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < u_O->size(); ++i) {
    const auto before = Index(mesh.Previous(static_cast<int>(i)));
    const double share =
        mesh.elements[i].length() / (mesh.elements[i].length() + mesh.elements[before].length());
    (*u_O)[i].head<2>() = share * at_end(before, 1) + (1 - share) * at_end(i, -1);
  }
}

void Bem2dModel::ComputeTractions(std::vector<float>* pascals) {
  const BoundaryState state = Shown();
  const BoundaryMesh& mesh = greens_.problem().mesh;
  std::vector<double> force(mesh.elements.size(), 0), length(force);  // by the length's unit
  for (int i = 0; i < greens_.size(); ++i) {
    Vector2d traction = state.traction[Index(i)];
    for (int axis = 0; axis < 2; ++axis) {
      if (greens_.held(i, axis)) traction[axis] = 0;  // of a support
    }
    const BoundaryNode& node = greens_.node(i);
    for (const int vertex : {node.element, mesh.Next(node.element)}) {
      force[Index(vertex)] += node.length * traction.norm();
      length[Index(vertex)] += node.length;
    }
  }
  pascals->resize(force.size());
  std::ranges::transform(force, length, pascals->begin(),
                         [](double f, double l) { return static_cast<float>(f / l); });
}

BoundaryState Bem2dModel::Boundary(const Solution& solution) {
  return Show(solution) ? Shown() : AtRest();
}

BoundaryState Bem2dModel::AtRest() const {
  const std::vector<Vector2d> zero(Index(greens_.size()), Vector2d::Zero());
  return {zero, zero};
}

BoundaryState Bem2dModel::Shown() const {
  if (!answered_) return AtRest();
  BoundaryState state;
  if (moving_knows_) {
    moving_.Boundary(prescribed_, &state.displacement, &state.traction);
  } else {
    solver_.Boundary(prescribed_, &state.displacement, &state.traction);
  }
  for (auto& u : state.displacement) u *= length_unit_;
  for (auto& t : state.traction) t *= params_.young_modulus;
  return state;
}

}  // namespace palpate
