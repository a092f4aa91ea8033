// What one reader of WatchMesh is told: the topology once, then places, as numbers or as moves.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "shared/wire/shape_code.h"
#include "slave/pipeline/sensing_pipeline.h"

namespace palpate {

class MeshStreamEncoder {
 public:
  // Throws std::invalid_argument: `relative_error`, and what is accepted.
  explicit MeshStreamEncoder(const v1::WatchMeshRequest& request);
  // Of the shape that Encode is given.
  [[nodiscard]] bool needs_nodal_forces() const { return nodal_forces_ || traction_; }
  // Overwrites `message`.
  void Encode(const BoundaryShape& shape, v1::MeshState* message);

 private:
  void Shorten(const BoundaryShape& shape, std::size_t budget, v1::MeshState* message);
  // Bytes that it took.
  std::size_t EncodeTraction(const BoundaryShape& shape, v1::MeshState* message) const;

  const double relative_error_;          // of the object's diagonal; 0: all numbers
  const std::size_t budget_;             // of moves and traction of a message [bytes]
  const bool nodal_forces_, traction_;   // asked for
  std::vector<std::uint32_t> elements_;  // as the reader knows them
  std::vector<float> rest_;              // likewise
  std::vector<double> areas_;            // of its nodes, at rest [m^2]; 0 on an outline
  ShapeEncoder encoder_;
};

}  // namespace palpate
