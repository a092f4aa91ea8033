// The object's surface as computed by the slave: a checked MeshState. Frame S [m].
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "shared/state/clock.h"
#include "shared/state/validity.h"

namespace palpate {

namespace v1 {
class MeshState;
}

// Constant part of the mesh. Either the triangles or the lines are empty.
struct MeshTopology {
  SurfaceMesh surface;                     // nodes at rest, and the triangles of a volume's surface
  std::vector<std::array<int, 2>> lines;   // the outline of a planar object
  std::vector<std::uint32_t> fixed_nodes;  // fixed nodes of the scene
  // Constant part of the field, see DisplacementField of state.proto; empty: not requested.
  std::vector<std::uint32_t> field_triangles;  // node indices, three at a time
  std::vector<float> field_rest;               // x, y, z per node, frame O [m]
};

struct RemoteMesh {
  std::uint64_t sequence = 0;  // of the state it belongs to
  Time sensed_at{};            // slave's clock
  Validity validity = Validity::kFailed;
  std::shared_ptr<const MeshTopology> topology;  // never null
  std::vector<Eigen::Vector3d> positions;        // deformed, one per node
  std::vector<Eigen::Vector3d> nodal_forces;     // tool on node [N]; empty: unknown
  std::vector<float> traction;                   // of the tool, per node [Pa]; empty: unknown
  // Displacement x, y, z per node of the field, frame O [m]; empty: not requested, or no model.
  std::vector<float> displacement;
  // Displaced position u, v per node of the field in the image [px]; NaN: behind the camera; empty:
  // there is no camera.
  std::vector<float> image;

  // Largest distance of a node from its rest position [m]; 0 if it is below single precision for an
  // object of this size.
  [[nodiscard]] double LargestDeflection() const;
};

// Converts a message. `known`: the previous topology, or null; it is used unless the message
// contains one. nullopt: a number is not finite or absurd, an index is invalid, or sizes do not
// match; `reason` then states which.
std::optional<RemoteMesh> FromProto(const v1::MeshState& message,
                                    const std::shared_ptr<const MeshTopology>& known,
                                    std::string* reason);

}  // namespace palpate
