#include "slave/pipeline/points/surface_shape.h"

#include <utility>
#include <variant>

#include "shared/mesh/files/mesh_file.h"

namespace palpate {
namespace {

void Append(std::vector<float>* out, const Eigen::Vector3d& v) {
  for (const double x : v) out->push_back(static_cast<float>(x));
}

// The surface at rest; deformed nodes and forces are still to come.
BoundaryShape AtRest(const SurfaceMesh& surface, const Eigen::Isometry3d& X_SO,
                     const ContactEstimate& felt) {
  BoundaryShape shape;
  shape.state_sequence = felt.sequence;
  shape.sensed_at = felt.sensed_at;
  shape.validity = felt.validity;
  shape.nodes_per_element = 3;
  for (const auto& triangle : surface.triangles) {
    for (const int node : triangle) shape.elements.push_back(static_cast<std::uint32_t>(node));
  }
  for (const Eigen::Vector3d& p_O : surface.nodes) Append(&shape.rest, X_SO * p_O);
  return shape;
}

}  // namespace

BoundaryShape MakeSurfaceShape(SurfaceEstimator& estimator, const ContactEstimate& felt,
                               bool nodal_forces) {
  BoundaryShape shape = AtRest(estimator.body().surface(), estimator.X_SO(), felt);
  std::vector<Eigen::Vector3d> per_node;  // frame S
  estimator.DeformedNodes(&per_node);
  for (const Eigen::Vector3d& p_S : per_node) Append(&shape.positions, p_S);
  if (!nodal_forces || !felt.force) return shape;
  estimator.NodalForces(&per_node);
  for (const Eigen::Vector3d& f_S : per_node) Append(&shape.nodal_forces, f_S);
  return shape;
}

SurfaceMesh FollowedSurface(const Scene& scene) {
  const auto* geometry = std::get_if<MeshFileGeometry>(&scene.object.geometry);
  if (geometry == nullptr) return {};
  MeshFile file = ReadMeshFile(geometry->file, geometry->unit);
  auto* surface = std::get_if<SurfaceMesh>(&file.mesh);
  return surface != nullptr ? std::move(*surface) : SurfaceMesh{};
}

BoundaryShape MakeFollowedShape(const SurfaceMesh& surface, const Eigen::Isometry3d& X_SO,
                                const ContactEstimate& felt, const Eigen::Vector3d& moved) {
  BoundaryShape shape = AtRest(surface, X_SO, felt);
  for (const Eigen::Vector3d& p_O : surface.nodes) Append(&shape.positions, X_SO * p_O + moved);
  return shape;
}

}  // namespace palpate
