// The object's surface as the slave sees it: what a MeshState says, checked. Frame S [m].
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
#include "shared/wire/traction_code.h"

namespace palpate {

namespace v1 {
class MeshState;
}

// What stays while the object deforms. Of triangles and lines one is empty.
struct MeshTopology {
  SurfaceMesh surface;                     // nodes at rest, and the triangles of a volume's surface
  std::vector<std::array<int, 2>> lines;   // the outline of a planar object
  std::vector<std::uint32_t> fixed_nodes;  // nodes that the scene holds
};

struct RemoteMesh {
  std::uint64_t sequence = 0;  // of the state it belongs to
  Time sensed_at{};            // slave's clock
  Validity validity = Validity::kFailed;
  std::shared_ptr<const MeshTopology> topology;  // never null
  std::vector<Eigen::Vector3d> positions;        // deformed, one per node
  std::vector<Eigen::Vector3d> nodal_forces;     // tool on node [N]; empty: not told
  NodeTraction traction;                         // of the tool; without steps: not told

  // How far the node that moved most is from its place at rest [m]; none if less than single
  // precision tells of an object of this size.
  [[nodiscard]] double LargestDeflection() const;
};

// `known`: the topology that came before, null: none; it stays unless the message brings another.
// nullopt: a number is not finite or absurd, an index points nowhere, sizes do not fit; `reason`
// then says which.
std::optional<RemoteMesh> FromProto(const v1::MeshState& message,
                                    const std::shared_ptr<const MeshTopology>& known,
                                    std::string* reason);

// The meshes of one stream, in their order: places that are told as moves add up.
class MeshReader {
 public:
  // As FromProto says, or: moves that are none, or that follow on such. Takes `message` apart.
  std::optional<RemoteMesh> Read(v1::MeshState* message, std::string* reason);
  // Moves were refused: until another topology comes nobody knows where anything is.
  [[nodiscard]] bool is_lost() const { return is_lost_; }
  [[nodiscard]] bool has_topology() const { return topology_ != nullptr; }

 private:
  // Puts `positions` in place of `moves`; false: they do not fit.
  bool Expand(v1::MeshState* message);

  std::shared_ptr<const MeshTopology> topology_;
  std::vector<float> rest_;  // x, y, z per node, S [m]
  ShapeUnits moved_;
  double unit_ = 0;  // 0: not told yet [m]
  bool is_lost_ = false;
};

}  // namespace palpate
