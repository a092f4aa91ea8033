#include "slave/mechanics/bem3d/bem3d_model.h"

#include <algorithm>
#include <new>
#include <utility>

#include "shared/geometry/index.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kBalanced = 1e-6;  // of all loads together

// Before the Green's functions, which take long.
double Checked(double young_modulus, double range) {
  RequirePositive("young_modulus", young_modulus);
  RequirePositive("range", range);
  return young_modulus;
}

}  // namespace

Bem3dModel::Bem3dModel(const SurfaceMesh& mesh, HeldNodes held, double young_modulus,
                       double poisson_ratio, const Options& options, Progress* progress)
    : young_modulus_(Checked(young_modulus, options.range)),
      greens_(mesh, std::move(held), poisson_ratio,
              {.cache = options.cache, .memory_limit = options.memory_limit}, progress),
      places_(mesh, AnyHeld(greens_.system().held())),
      solver_(greens_, places_,
              {.young_modulus = young_modulus,
               .larger_side = greens_.length_unit(),
               .range = options.range,
               .contact = options.contact,
               .poisson_ratio = poisson_ratio}),
      force_unit_(young_modulus * greens_.length_unit() * greens_.length_unit()) {
  field_mesh_ = {.vertices = mesh.nodes, .triangles = mesh.triangles};
  Describe(options);
}

void Bem3dModel::Describe(const Options& options) {
  info_.kind = "bem3d";
  info_.dof = 3 * Index(greens_.places());
  info_.elements = greens_.places();
  info_.memory_bytes = greens_.memory_bytes();
  info_.condition = greens_.condition();
  info_.range = options.range;
  info_.remark = greens_.remark().empty() ? "small strains only" : greens_.remark();
  info_.update_us = MeasureUpdate();
  NotePrecompute();
}

// Two triangles in turn [us]; 0 where no two can be moved.
double Bem3dModel::MeasureUpdate() {
  std::array<Contact, 2> contacts;
  std::size_t found = 0;
  for (int i = 0; i < greens_.places() && found < 2; ++i) {
    const auto& held = greens_.system().held()[Index(i)];
    if (!held[0] && !held[1] && !held[2]) contacts[found++].element = i;
  }
  if (found < 2) return 0;
  return ComplianceSolver::MeasureUpdate(greens_, places_, solver_.params(), contacts);
}

void Bem3dModel::ComputeResponses(std::span<const Contact> contacts,
                                  std::span<ContactResponse> responses) noexcept {
  failure_ = Refuse(contacts);
  if (failure_.empty()) {
    solver_.Respond(contacts, responses);
    if (greens_.system().free_motions() == 0 || !solver_.failure().empty() || Balanced()) return;
  }
  std::ranges::fill(responses, ContactResponse{});
}

std::string_view Bem3dModel::Refuse(std::span<const Contact> contacts) const noexcept {
  if (greens_.system().free_motions() == 0) return {};
  const bool moved = std::ranges::any_of(
      contacts, [](const Contact& c) { return c.kind == Contact::Kind::kDisplacement; });
  if (!moved) return {};
  return "displacements are prescribed on a body without fixed boundary: accepted are loads";
}

// The loads do no work on the motions that are left free.
bool Bem3dModel::Balanced() {
  try {
    solver_.Forces(&forces_);
  } catch (const std::bad_alloc&) {
    return Fail("out of memory");
  }
  const ReferenceSystem& system = greens_.system();
  Eigen::Matrix<double, 6, 1> work = Eigen::Matrix<double, 6, 1>::Zero();
  double total = 0;
  for (const auto& [place, force_O] : forces_) {
    const auto& triangle = system.surface().elements[Index(place)];
    work += system.RigidModes(triangle.centroid).transpose() * force_O;
    total += force_O.norm();
  }
  if (work.cwiseAbs().maxCoeff() <= kBalanced * total) return true;
  return Fail("loads on a body that is free to move do not balance");
}

void Bem3dModel::AtCentroids(std::vector<Vector3d>* u_O) {
  if (failure_.empty()) {
    solver_.Displacement(u_O);
  } else {
    u_O->assign(Index(greens_.places()), Vector3d::Zero());
  }
}

void Bem3dModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  AtCentroids(&centroids_);
  u_O->assign(field_mesh_.vertices.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < field_mesh_.triangles.size(); ++t) {
    const auto& corners = greens_.system().corners(static_cast<int>(t));
    for (std::size_t k = 0; k < 3; ++k) {
      Vector3d& u = (*u_O)[Index(field_mesh_.triangles[t][k])];
      u = greens_.system().AtCorner(corners[k], centroids_);
    }
  }
}

SurfaceState Bem3dModel::Surface(const Solution& solution) {
  SurfaceState state;
  if (!Show(solution)) {
    state.displacement.assign(Index(greens_.places()), Vector3d::Zero());
    state.traction = state.displacement;
    return state;
  }
  AtCentroids(&state.displacement);
  state.traction.assign(state.displacement.size(), Vector3d::Zero());
  if (!failure_.empty()) return state;
  solver_.Forces(&forces_);
  const double area_unit = greens_.length_unit() * greens_.length_unit();
  const auto& elements = greens_.system().surface().elements;
  for (const auto& [place, force_O] : forces_) {
    const auto loaded = Index(place);
    state.traction[loaded] += force_O / (area_unit * elements[loaded].area);
    for (int i = 0; i < greens_.places(); ++i) {
      state.traction[Index(i)] +=
          young_modulus_ * greens_.Reaction(i, place, force_O / force_unit_);
    }
  }
  return state;
}

}  // namespace palpate
