#include "slave/mechanics/bem/bem2d_model.h"

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <utility>

#include <Eigen/Geometry>

#include "shared/text/text.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Error of the compliance [-]. [derived: the accepted 5 %, less a fifth because the estimate is
// only the first term of a series]
constexpr double kMaxMissing = 0.04;
// Error of the moment, divided by (force times width / number of elements of the patch) [-].
// [tuned: contact_moment_test]
constexpr double kSpreadByElements = 0.1;
constexpr double kBalance = 1e-6;  // of the sum of the forces' magnitudes

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

double LargerSideOf(const BoundaryMesh& mesh) {
  Eigen::AlignedBox2d box;
  for (const auto& e : mesh.elements) box.extend(e.a);
  return box.sizes().maxCoeff();
}

// Displacements prescribed on the whole boundary of an almost incompressible body do not determine
// its pressure.
int MaxRows(const GreensFunctions& greens) {
  const auto& problem = greens.problem();
  if (problem.plane != Plane::kStrain || problem.nu <= GreensFunctions::kMaxNuAllHeld) {
    return std::numeric_limits<int>::max();
  }
  int free = 0;
  for (int i = 0; i < greens.size(); ++i) {
    free += (greens.held(i, 0) ? 0 : 1) + (greens.held(i, 1) ? 0 : 1);
  }
  return free - 1 + 2 * greens.motions();
}

}  // namespace

Bem2dModel::Bem2dModel(ReferenceProblem problem, const Params& params, Progress* progress)
    : params_(Checked(params, problem, progress)),
      greens_(std::move(problem), progress),
      larger_side_(LargerSideOf(greens_.problem().mesh)),
      places_(greens_, larger_side_),
      solver_(
          greens_, places_,
          {.young_modulus = params.young_modulus,
           .larger_side = larger_side_,
           .range = params.range,
           .contact = params.contact,
           .poisson_ratio = greens_.problem().plane == Plane::kStrain ? greens_.problem().nu : 0,
           .thickness = params.thickness,
           .moment = {ElementPlaces::kMinForMoment,
                      kSpreadByElements * greens_.element_nodes().count}}),
      force_unit_(params.young_modulus * greens_.length_unit() * params.thickness),
      max_rows_(MaxRows(greens_)),
      probe_forces_(greens_.error().probes()) {
  const BoundaryMesh& mesh = greens_.problem().mesh;
  for (int i = 0; i < mesh.size(); ++i) {
    const Vector2d& a = mesh.elements[Index(i)].a;
    field_mesh_.vertices.emplace_back(a.x(), a.y(), 0);
    field_mesh_.lines.push_back({i, mesh.Next(i)});
  }
  Describe();
}

void Bem2dModel::Describe() {
  info_.kind = "bem2d";
  info_.dof = 2 * Index(greens_.size());
  info_.elements = greens_.problem().mesh.size();
  info_.memory_bytes = greens_.memory_bytes();
  info_.condition = greens_.condition();
  info_.range = params_.range;
  NotePrecompute();
  info_.update_us = MeasureUpdate();
}

// Measures the time of an update by moving two elements alternately [us]; 0: no two elements can be
// moved.
double Bem2dModel::MeasureUpdate() {
  std::array<Contact, 2> contacts;
  std::size_t found = 0;
  for (int i = 0; i < greens_.size() && found < 2; i += greens_.element_nodes().count) {
    if (!greens_.held(i, 0) && !greens_.held(i, 1)) {
      contacts[found++].element = greens_.node(i).element;
    }
  }
  if (found < 2) return 0;
  return ComplianceSolver::MeasureUpdate(greens_, places_, solver_.params(), contacts);
}

void Bem2dModel::ComputeResponses(std::span<const Contact> contacts,
                                  std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  solver_.Respond(contacts, responses);
  try {
    answered_ = solver_.answered() && Accept();
    for (std::size_t i = 0; answered_ && i < contacts.size(); ++i) {
      AddReaction(solver_.slots()[i], &responses[i]);
    }
  } catch (const std::bad_alloc&) {
    answered_ = Fail("out of memory");
  }
  if (!answered_) {
    std::ranges::fill(responses, ContactResponse{});
  } else if (HasElementError(responses)) {
    for (ContactResponse& response : responses) {
      response.validity = Validity::kExtrapolated;
      response.flag_reason = kCoarseElements;
    }
  }
}

// Also computes the forces where they are needed.
bool Bem2dModel::Accept() {
  if (solver_.rows() > max_rows_) {
    return Fail("displacements are prescribed on the whole boundary of an incompressible body");
  }
  const bool must_balance = greens_.free_motions() > 0 && solver_.rows() == 0;
  const bool on_support = std::ranges::any_of(solver_.slots(), [](const ContactSlot& slot) {
    return slot.load < 0 && (slot.held[0] || slot.held[1]);
  });
  if (must_balance || on_support) solver_.Forces(&forces_);
  return !must_balance || Balances() || Fail("loads on a body that is free to move do not balance");
}

// Returns whether the loads do no work on the free rigid motions.
bool Bem2dModel::Balances() const {
  Eigen::Vector3d work = Eigen::Vector3d::Zero();
  double magnitude = 0;
  for (const auto& [place, force_O] : forces_) {
    work += greens_.RigidModes(greens_.node(place).p_O).transpose() * force_O.head<2>();
    magnitude += force_O.norm();
  }
  return work.cwiseAbs().maxCoeff() <= kBalance * magnitude;
}

Vector2d Bem2dModel::AmplitudeOf(const PlaceForce& at) const {
  Vector2d amplitude = at.force_O.head<2>() / force_unit_;
  if (at.place >= greens_.size()) return amplitude;
  for (int c = 0; c < 2; ++c) {
    if (greens_.held(at.place, c)) amplitude[c] = 0;
  }
  return amplitude / greens_.measure(at.place);
}

// Adds the reaction of supports to a contact: E has their tractions in the rows of fixed
// components. The stiffness is unknown along components that are fixed somewhere under the contact.
void Bem2dModel::AddReaction(const ContactSlot& slot, ContactResponse* response) const {
  if (slot.load >= 0 || !(slot.held[0] || slot.held[1])) return;
  Vector2d reaction = Vector2d::Zero();
  for (const PlaceForce& by : forces_) {
    const Vector2d amplitude = AmplitudeOf(by);
    for (const auto& [place, weight] : slot.footprint.places) {
      const Vector2d traction =
          Eigen::Map<const Matrix2d>(greens_.block(place, by.place)) * amplitude;
      for (int c = 0; c < 2; ++c) {
        if (greens_.held(place, c)) reaction[c] += greens_.measure(place) * traction[c];
      }
    }
  }
  if (params_.contact == ContactLaw::kFrictionless) {
    const Vector2d n = slot.footprint.normal_O.head<2>();
    reaction = n * n.dot(reaction);
  }
  response->force_O.head<2>() += force_unit_ * reaction;
  for (int c = 0; c < 2; ++c) {
    if (!slot.held[Index(c)]) continue;
    response->stiffness_O.row(c).setZero();
    response->stiffness_O.col(c).setZero();
  }
}

bool Bem2dModel::HasElementError(std::span<const ContactResponse> responses) noexcept {
  const ElementError& error = greens_.error();
  if (error.probes() == 0) return false;
  std::ranges::fill(probe_forces_, Vector2d(0, 0));
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const auto& places = solver_.slots()[i].footprint.places;
    const double share = 1 / (force_unit_ * static_cast<double>(places.size()));
    for (const auto& [place, weight] : places) {
      probe_forces_[Index(error.ProbeOf(greens_.node(place).element))] +=
          share * responses[i].force_O.head<2>();
    }
  }
  return error.MissingPart(probe_forces_) > kMaxMissing;
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

PlanarCover Bem2dModel::MakeCover() const {
  return CoverOf(greens_.problem().mesh, kCoverPlaces);
}

void Bem2dModel::ComputeInside(const std::vector<Vector2d>& places,
                               std::vector<Eigen::Vector3d>* u_O) {
  if (inside_H_.size() == 0) greens_.Inside(places, &inside_H_, &inside_G_);
  const BoundaryState state = Shown();
  const auto size = static_cast<Eigen::Index>(2 * state.displacement.size());
  const Eigen::VectorXd u = Eigen::Map<const Eigen::VectorXd>(state.displacement[0].data(), size);
  const Eigen::VectorXd t = Eigen::Map<const Eigen::VectorXd>(state.traction[0].data(), size) *
                            (greens_.length_unit() / params_.young_modulus);
  const Eigen::VectorXd inside = inside_G_ * t - inside_H_ * u;
  for (Eigen::Index i = 0; i < inside.size(); i += 2) {
    u_O->emplace_back(inside[i], inside[i + 1], 0);
  }
}

void Bem2dModel::ComputeTractions(std::vector<float>* pascals) {
  const BoundaryState state = Shown();
  const BoundaryMesh& mesh = greens_.problem().mesh;
  // Lengths are divided by the unit of length.
  std::vector<double> force(mesh.elements.size(), 0), length(force);
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
  std::vector<PlaceForce> forces;
  solver_.Forces(&forces);
  BoundarySum sum(greens_);
  for (const PlaceForce& at : forces) sum.Add(at.place, AmplitudeOf(at));
  BoundaryState state;
  sum.Finish(&state.displacement, &state.traction);
  for (auto& u : state.displacement) u *= greens_.length_unit();
  for (auto& t : state.traction) t *= params_.young_modulus;
  return state;
}

}  // namespace palpate
