// Encodes the messages for one reader of WatchMesh: the topology once, then positions.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "slave/pipeline/base/sense_types.h"

namespace palpate {

class MeshStreamEncoder {
 public:
  explicit MeshStreamEncoder(const v1::WatchMeshRequest& request);
  // The parts of a shape that Encode needs.
  [[nodiscard]] ShapeParts needs() const { return {nodal_forces_ || traction_, field_}; }
  // Overwrites `message`.
  void Encode(const BoundaryShape& shape, v1::MeshState* message);

 private:
  const bool nodal_forces_, traction_, field_;  // requested
  std::vector<std::uint32_t> elements_;         // topology that the reader has received
  std::vector<double> areas_;                   // of its nodes, at rest [m^2]; 0 on an outline
};

}  // namespace palpate
