#include "slave/mechanics/bem3d/bem3d_model.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace palpate {
namespace {

using Eigen::Vector3d;
using Clock = std::chrono::steady_clock;

constexpr double kBalanced = 1e-6;  // of all loads together

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Before the Green's functions, which take long.
double Checked(double young_modulus, double range) {
  const auto require = [](const char* name, double value) {
    if (value > 0 && std::isfinite(value)) return;
    throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) +
                                ": accepted is finite and > 0");
  };
  require("young_modulus", young_modulus);
  require("range", range);
  return young_modulus;
}

ComplianceSolver::Params SolverParams(const SurfaceGreens& greens, double young_modulus,
                                      const Bem3dModel::Options& options) {
  return {.young_modulus = young_modulus,
          .larger_side = greens.length_unit(),
          .range = options.range,
          .contact = options.contact};
}

}  // namespace

Bem3dModel::Bem3dModel(const SurfaceMesh& mesh, std::vector<std::array<bool, 3>> held,
                       double young_modulus, double poisson_ratio, const Options& options,
                       Progress* progress)
    : young_modulus_(Checked(young_modulus, options.range)),
      greens_(mesh, std::move(held), poisson_ratio,
              {.cache = options.cache, .memory_limit = options.memory_limit}, progress),
      places_(mesh),
      solver_(greens_, places_, SolverParams(greens_, young_modulus, options)),
      force_unit_(young_modulus * greens_.length_unit() * greens_.length_unit()) {
  field_mesh_ = {.vertices = mesh.nodes, .triangles = mesh.triangles};
  Describe(options);
}

void Bem3dModel::Describe(const Options& options) {
  info_.kind = "bem3d";
  info_.dof = 3 * static_cast<std::size_t>(greens_.places());
  info_.elements = greens_.places();
  info_.memory_bytes = greens_.memory_bytes();
  info_.condition = greens_.condition();
  info_.range = options.range;
  info_.remark = greens_.remark().empty() ? "small strains only" : greens_.remark();
  info_.update_us = MeasureUpdate(options);
  info_.precompute_s = SecondsSince(started_);
}

// Two triangles in turn [us]; 0 where no two can be moved.
double Bem3dModel::MeasureUpdate(const Options& options) {
  ComplianceSolver solver(greens_, places_, SolverParams(greens_, young_modulus_, options));
  std::array<Contact, 2> contacts;
  std::size_t found = 0;
  for (int i = 0; i < greens_.places() && found < 2; ++i) {
    const auto& held = greens_.system().held()[static_cast<std::size_t>(i)];
    if (!held[0] && !held[1] && !held[2]) contacts[found++].element = i;
  }
  if (found < 2) return 0;
  ContactResponse response;
  constexpr int kTimes = 1000;
  Clock::time_point start;
  for (int i = -2; i < kTimes; ++i) {  // the first two make room
    if (i == 0) start = Clock::now();
    solver.Respond({&contacts[static_cast<std::size_t>(i & 1)], 1}, {&response, 1});
    if (response.validity == Validity::kFailed) return 0;
  }
  return 1e6 * SecondsSince(start) / kTimes;
}

void Bem3dModel::Respond(std::span<const Contact> contacts,
                         std::span<ContactResponse> responses) noexcept {
  refused_ = Refuse(contacts);
  if (refused_.empty()) {
    solver_.Respond(contacts, responses);
    if (greens_.system().free_motions() == 0 || !solver_.failure().empty() || Balanced()) return;
  }
  std::ranges::fill(responses, ContactResponse{});
}

std::string_view Bem3dModel::failure() const {
  return refused_.empty() ? solver_.failure() : refused_;
}

std::string_view Bem3dModel::Refuse(std::span<const Contact> contacts) const noexcept {
  if (greens_.system().free_motions() == 0) return {};
  const bool moved = std::ranges::any_of(
      contacts, [](const Contact& c) { return c.kind == Contact::Kind::kDisplacement; });
  if (!moved) return {};
  return "displacements are prescribed on a body that is free to move: accepted are loads";
}

// The loads do no work on the motions that are left free.
bool Bem3dModel::Balanced() {
  try {
    solver_.Forces(&forces_);
  } catch (const std::bad_alloc&) {
    refused_ = "out of memory";
    return false;
  }
  const ReferenceSystem& system = greens_.system();
  Eigen::Matrix<double, 6, 1> work = Eigen::Matrix<double, 6, 1>::Zero();
  double total = 0;
  for (const auto& [place, force_O] : forces_) {
    const auto& triangle = system.surface().elements[static_cast<std::size_t>(place)];
    work += system.RigidModes(triangle.centroid).transpose() * force_O;
    total += force_O.norm();
  }
  if (work.cwiseAbs().maxCoeff() <= kBalanced * total) return true;
  refused_ = "loads on a body that is free to move do not balance";
  return false;
}

void Bem3dModel::AtCentroids(std::vector<Vector3d>* u_O) {
  if (refused_.empty()) {
    solver_.Displacement(u_O);
  } else {
    u_O->assign(static_cast<std::size_t>(greens_.places()), Vector3d::Zero());
  }
}

void Bem3dModel::Displacements(std::vector<Vector3d>* u_O) {
  AtCentroids(&centroids_);
  u_O->assign(field_mesh_.vertices.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < field_mesh_.triangles.size(); ++t) {
    const auto& corners = greens_.system().corners(static_cast<int>(t));
    for (std::size_t k = 0; k < 3; ++k) {
      Vector3d& u = (*u_O)[static_cast<std::size_t>(field_mesh_.triangles[t][k])];
      u = greens_.system().AtCorner(corners[k], centroids_);
    }
  }
}

SurfaceState Bem3dModel::Surface() {
  SurfaceState state;
  AtCentroids(&state.displacement);
  state.traction.assign(state.displacement.size(), Vector3d::Zero());
  if (!refused_.empty()) return state;
  solver_.Forces(&forces_);
  const double area_unit = greens_.length_unit() * greens_.length_unit();
  const auto& elements = greens_.system().surface().elements;
  for (const auto& [place, force_O] : forces_) {
    const auto loaded = static_cast<std::size_t>(place);
    state.traction[loaded] += force_O / (area_unit * elements[loaded].area);
    for (int i = 0; i < greens_.places(); ++i) {
      state.traction[static_cast<std::size_t>(i)] +=
          young_modulus_ * greens_.Reaction(i, place, force_O / force_unit_);
    }
  }
  return state;
}

Vector3d Bem3dModel::DisplacementInside(const SurfaceState& state, const Vector3d& p_O) const {
  const double unit = greens_.length_unit();
  const ReferenceSystem& system = greens_.system();
  const Vector3d p = (p_O - system.surface().origin_O) / unit;
  std::vector<Vector3d> u, t;
  for (const auto& v : state.displacement) u.emplace_back(v / unit);
  for (const auto& v : state.traction) t.emplace_back(v / young_modulus_);
  return unit * system.Inside(p, u, t);
}

}  // namespace palpate
