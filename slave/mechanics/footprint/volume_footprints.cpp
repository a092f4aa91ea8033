#include "slave/mechanics/footprint/volume_footprints.h"

#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

SurfaceMesh InMetres(SurfaceMesh surface, double unit) {
  for (Vector3d& node : surface.nodes) node *= unit;
  return surface;
}

}  // namespace

VolumeFootprints::VolumeFootprints(const TetMesh& mesh, double unit,
                                   const std::vector<char>& uneven)
    : mesh_(mesh),
      unit_(unit),
      nodes_(InMetres(mesh.touch_surface, unit), uneven, is_quadratic()),
      triangles_(InMetres(mesh.surface, unit), uneven),
      load_(mesh.nodes.size(), 0) {}

std::string_view VolumeFootprints::OnNodes(const Contact& contact, ContactFootprint* footprint) {
  const bool is_loaded = contact.width > 0 && contact.kind == Contact::Kind::kForce;
  const bool on_quarters = is_quadratic() && !is_loaded;
  Contact found = contact;
  if (on_quarters) found.element = QuarterOf(contact);
  const std::string_view refusal = is_quadratic() && is_loaded ? FindLoaded(contact, footprint)
                                                               : nodes_.OnNodes(found, footprint);
  if (refusal.empty()) footprint->triangle = footprint->at.triangle / (on_quarters ? 4 : 1);
  return refusal;
}

std::string_view VolumeFootprints::OnTool(const Contact& contact, bool whole,
                                          ContactFootprint* footprint) {
  Contact found = contact;
  if (is_quadratic()) found.element = QuarterOf(contact);
  const std::string_view refusal = nodes_.OnTool(found, whole, footprint);
  if (refusal.empty()) footprint->triangle = footprint->at.triangle / (is_quadratic() ? 4 : 1);
  return refusal;
}

// Quarters 0 to 2 hold a corner each, 3 the centre (TetMesh::touch_surface).
int VolumeFootprints::QuarterOf(const Contact& contact) const {
  const int triangle = contact.element;
  if (triangle < 0 || triangle >= static_cast<int>(mesh_.faces.size())) return triangle;
  const auto& face = mesh_.faces[Index(triangle)];
  const Vector3d &a = mesh_.nodes[Index(face[0])], &b = mesh_.nodes[Index(face[1])],
                 &c = mesh_.nodes[Index(face[2])];
  const Vector3d area = (b - a).cross(c - a), from_a = contact.p_O / unit_ - a;
  Vector3d weights;
  weights[1] = from_a.cross(c - a).dot(area) / area.squaredNorm();
  weights[2] = (b - a).cross(from_a).dot(area) / area.squaredNorm();
  weights[0] = 1 - weights[1] - weights[2];
  int nearest = 0;
  const double most = weights.maxCoeff(&nearest);
  return 4 * triangle + (most > 0.5 ? nearest : 3);
}

std::string_view VolumeFootprints::FindLoaded(const Contact& contact, ContactFootprint* footprint) {
  const std::string_view refusal =
      triangles_.OnTriangles(contact, footprint, PatchBasis::kLoadedTriangles10);
  if (!refusal.empty()) return refusal;
  loaded_.assign(footprint->places.begin(), footprint->places.end());
  footprint->places.clear();
  for (const auto& [triangle, share] : loaded_) {
    const auto& face = mesh_.faces[Index(triangle)];
    for (std::size_t i = 3; i < face.size(); ++i) {
      if (load_[Index(face[i])] == 0) footprint->places.push_back({face[i], 0});
      load_[Index(face[i])] += share / 3;
    }
  }
  std::ranges::sort(footprint->places, {}, &PlaceWeight::place);
  footprint->arms.clear();
  for (PlaceWeight& touched : footprint->places) {
    const auto node = Index(touched.place);
    touched.weight = std::exchange(load_[node], 0);
    footprint->arms.push_back(unit_ * mesh_.nodes[node] - contact.p_O);
  }
  if (footprint->reach != 0) footprint->arms.clear();
  CentreArms(
      triangles_.patch().disc, [&](std::size_t i) { return footprint->places[i].weight; },
      &footprint->arms);
  return {};
}

}  // namespace palpate
