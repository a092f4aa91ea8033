#include "slave/pipeline/press/membrane_body.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/geometry/index.h"
#include "slave/contact/surface_contact.h"

namespace palpate {
namespace {

constexpr double kStandsOut = 5;  // sigmas, of a force that counts as contact

TrianglePlace NearestOn(const SurfaceMesh& mesh, const Eigen::Vector3d& p, int* triangle) noexcept {
  TrianglePlace nearest;
  nearest.distance_squared = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    const auto at = [&](std::size_t k) { return mesh.nodes[Index(corners[k])]; };
    const TrianglePlace place = ClosestOnTriangle(
        p, {at(0), at(1), at(2)},
        {corners[0] < corners[1], corners[1] < corners[2], corners[2] < corners[0]});
    if (place.distance_squared < nearest.distance_squared) {
      nearest = place;
      *triangle = static_cast<int>(t);
    }
  }
  return nearest;
}

// `seconds`: what the precompute took.
MembranePress MakePress(InflatedMembrane membrane, double patch, double* seconds) {
  if (!(patch > 0)) {
    throw std::invalid_argument("patch = " + std::to_string(patch) + ": accepted is > 0 m");
  }
  MembranePress::Params params;
  params.pressure_is_measured = false;
  params.patch = patch;
  const auto start = std::chrono::steady_clock::now();
  MembranePress press(std::move(membrane), params);
  *seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return press;
}

}  // namespace

MembraneBody::MembraneBody(InflatedMembrane membrane, double patch)
    : press_(MakePress(std::move(membrane), patch, &info_.precompute_s)), patch_(patch) {
  info_.kind = "membrane";
  info_.dof = 3 * (surface().nodes.size() - press_.membrane().held().size());
  info_.elements = static_cast<int>(surface().triangles.size());
  info_.memory_bytes = sizeof(double) * surface().nodes.size() * surface().nodes.size();
  info_.remark = "linear about the shape at rest";
}

SurfaceLoad MembraneBody::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  const auto& reading = press_.Fit(points_O);
  load_ = {};
  if (!reading.found) {
    load_.validity = Validity::kTrackingLost;
    load_.why = "too few points of the membrane are in view";
    return load_;
  }
  load_.p_O = reading.p_O;
  load_.n_O = reading.n_O;
  load_.sigma_force = reading.sigma_own_force;
  load_.sigma_place = reading.sigma_place;
  load_.residual = reading.relative_residual;
  load_.validity = Validity::kValid;
  if (!(reading.own_force > kStandsOut * reading.sigma_own_force)) return load_;
  load_.force = -reading.own_force;
  load_.depth = reading.depth;
  if (load_.depth > patch_ / 2) {
    load_.validity = Validity::kExtrapolated;
    load_.why = "the dent is deeper than half the tool's contact is wide";
  }
  return load_;
}

LoadIdentifier::Press MembraneBody::PressAt(const Eigen::Vector3d& p_O, double depth) noexcept {
  Press press;
  if (!(p_O.allFinite() && std::isfinite(depth))) return press;
  int triangle = 0;
  const TrianglePlace place = NearestOn(surface(), p_O, &triangle);
  const double give =
      press_.compliance().GiveAt(surface().triangles[Index(triangle)], place.weights);
  if (!(give > 0)) return press;  // on the rim nothing gives
  press.stiffness = 1 / give;
  press.force = std::max(0.0, depth) / give;
  press.valid = true;
  return press;
}

void MembraneBody::Nearest(const Eigen::Vector3d& p_O_tip, Eigen::Vector3d* p_O,
                           Eigen::Vector3d* n_O) const noexcept {
  int triangle = 0;
  const TrianglePlace place = NearestOn(surface(), p_O_tip, &triangle);
  *p_O = place.p;
  n_O->setZero();
  const auto& corners = surface().triangles[Index(triangle)];
  for (int k = 0; k < 3; ++k) {
    const auto node = static_cast<std::size_t>(corners[static_cast<std::size_t>(k)]);
    *n_O += place.weights[k] * press_.membrane().normals()[node];
  }
  n_O->normalize();
}

void MembraneBody::NodalForces(std::vector<Eigen::Vector3d>* f_O) {
  f_O->assign(surface().nodes.size(), Eigen::Vector3d::Zero());
  if (load_.force == 0) return;
  const SurfacePlace& place = press_.place();
  const auto& corners = surface().triangles[Index(place.triangle)];
  for (int k = 0; k < 3; ++k) {
    for (const auto& share : press_.compliance().shares(corners[Index(k)])) {
      const auto node = Index(share.node);
      (*f_O)[node] +=
          place.weights[k] * share.share * load_.force * press_.membrane().normals()[node];
    }
  }
}

void MembraneBody::Displacements(std::vector<Eigen::Vector3d>* u_O) {
  std::vector<Eigen::Vector3d> forces;
  NodalForces(&forces);
  press_.membrane().Displace(forces, u_O);
}

}  // namespace palpate
