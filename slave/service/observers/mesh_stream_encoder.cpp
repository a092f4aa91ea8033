#include "slave/service/observers/mesh_stream_encoder.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "slave/service/messages.h"

namespace palpate {
namespace {

// Returns for each node a third of the area of the triangles around it, at rest [m^2].
std::vector<double> AreasOf(const BoundaryShape& shape) {
  std::vector<double> areas(shape.rest.size() / 3, 0);
  if (shape.nodes_per_element != 3) return areas;
  const auto at = [&](std::uint32_t node) {
    return Eigen::Vector3d(Eigen::Map<const Eigen::Vector3f>(&shape.rest[3 * node]).cast<double>());
  };
  for (std::size_t i = 0; i + 2 < shape.elements.size(); i += 3) {
    const std::uint32_t a = shape.elements[i], b = shape.elements[i + 1], c = shape.elements[i + 2];
    const double area = 0.5 * (at(b) - at(a)).cross(at(c) - at(a)).norm();
    for (const std::uint32_t node : {a, b, c}) areas[node] += area / 3;
  }
  return areas;
}

// Returns the traction at the nodes [Pa]: that of the model, else the force on each node divided by
// its part of the surface. Empty: unknown.
std::vector<double> TractionOf(const BoundaryShape& shape, const std::vector<double>& areas) {
  const bool is_reported = !shape.traction.empty() || shape.nodes_per_element != 3;
  if (is_reported) return {shape.traction.begin(), shape.traction.end()};
  std::vector<double> pascals;
  for (std::size_t i = 0; 3 * i < shape.nodal_forces.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3f> force(&shape.nodal_forces[3 * i]);
    pascals.push_back(areas[i] > 0 ? static_cast<double>(force.norm()) / areas[i] : 0);
  }
  return pascals;
}

}  // namespace

MeshStreamEncoder::MeshStreamEncoder(const v1::WatchMeshRequest& request)
    : nodal_forces_(request.nodal_forces()),
      traction_(request.traction()),
      field_(request.field()) {}

void MeshStreamEncoder::Encode(const BoundaryShape& shape, v1::MeshState* message) {
  const bool with_topology = shape.elements != elements_;
  ToProto(shape, with_topology, message);
  if (!nodal_forces_) message->clear_nodal_forces();
  if (with_topology) {
    elements_ = shape.elements;
    areas_ = AreasOf(shape);
  }
  if (!traction_) return;
  const std::vector<double> traction = TractionOf(shape, areas_);
  const bool is_known =
      3 * traction.size() == shape.rest.size() &&
      std::ranges::all_of(traction, [](double p) { return std::isfinite(p) && p >= 0; });
  if (!is_known) return;
  for (const double pascals : traction) message->add_traction(static_cast<float>(pascals));
}

}  // namespace palpate
