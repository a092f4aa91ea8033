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
#include "shared/wire/shape_code.h"

namespace palpate {

namespace v1 {
class MeshState;
}

// Constant part of the mesh. Either the triangles or the lines are empty.
struct MeshTopology {
  SurfaceMesh surface;                     // nodes at rest, and the triangles of a volume's surface
  std::vector<std::array<int, 2>> lines;   // the outline of a planar object
  std::vector<std::uint32_t> fixed_nodes;  // fixed nodes of the scene
};

struct RemoteMesh {
  std::uint64_t sequence = 0;  // of the state it belongs to
  Time sensed_at{};            // slave's clock
  Validity validity = Validity::kFailed;
  std::shared_ptr<const MeshTopology> topology;  // never null
  std::vector<Eigen::Vector3d> positions;        // deformed, one per node
  std::vector<Eigen::Vector3d> nodal_forces;     // tool on node [N]; empty: unknown
  NodeTraction traction;                         // of the tool; without steps: unknown

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

// Reads the meshes of one stream in order, and adds up displacements between messages.
class MeshReader {
 public:
  // Like FromProto. Also rejects invalid displacements and all that follow. Modifies `message`.
  std::optional<RemoteMesh> Read(v1::MeshState* message, std::string* reason);
  // Displacements were rejected: positions are unknown until the next topology.
  [[nodiscard]] bool is_lost() const { return is_lost_; }

 private:
  // Replaces `moves` by `positions`; false: invalid.
  bool Expand(v1::MeshState* message);

  std::shared_ptr<const MeshTopology> topology_;
  std::vector<float> rest_;  // x, y, z per node, S [m]
  ShapeUnits moved_;
  double unit_ = 0;  // 0: unknown yet [m]
  bool is_lost_ = false;
};

}  // namespace palpate
