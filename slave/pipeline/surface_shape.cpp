#include "slave/pipeline/surface_shape.h"

namespace palpate {
namespace {

void Append(std::vector<float>* out, const Eigen::Vector3d& v) {
  for (const double x : v) out->push_back(static_cast<float>(x));
}

}  // namespace

BoundaryShape MakeSurfaceShape(SurfaceEstimator& estimator, bool nodal_forces) {
  const Felt& felt = estimator.felt();
  const SurfaceMesh& surface = estimator.body().surface();
  BoundaryShape shape;
  shape.state_sequence = felt.sequence;
  shape.sensed_at = felt.sensed_at;
  shape.validity = felt.validity;
  shape.nodes_per_element = 3;
  for (const auto& triangle : surface.triangles) {
    for (const int node : triangle) shape.elements.push_back(static_cast<std::uint32_t>(node));
  }
  for (const Eigen::Vector3d& p_O : surface.nodes) Append(&shape.rest, estimator.X_SO() * p_O);
  std::vector<Eigen::Vector3d> per_node;  // frame S
  estimator.DeformedNodes(&per_node);
  for (const Eigen::Vector3d& p_S : per_node) Append(&shape.positions, p_S);
  if (!nodal_forces || !felt.force) return shape;
  estimator.NodalForces(&per_node);
  for (const Eigen::Vector3d& f_S : per_node) Append(&shape.nodal_forces, f_S);
  return shape;
}

}  // namespace palpate
