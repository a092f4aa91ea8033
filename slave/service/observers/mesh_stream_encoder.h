// Encodes the messages for one reader of WatchMesh: the topology once, then positions, as numbers
// or as moves.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "shared/wire/shape_code.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

class MeshStreamEncoder {
 public:
  // Throws std::invalid_argument: `relative_error`, and what is accepted.
  explicit MeshStreamEncoder(const v1::WatchMeshRequest& request);
  // Settings for the shape that Encode gets.
  [[nodiscard]] bool needs_nodal_forces() const { return nodal_forces_ || traction_; }
  // Overwrites `message`.
  void Encode(const BoundaryShape& shape, v1::MeshState* message);

 private:
  void Shorten(const BoundaryShape& shape, std::size_t budget, v1::MeshState* message);
  // Size of the message in bytes.
  std::size_t EncodeTraction(const BoundaryShape& shape, v1::MeshState* message) const;

  const double relative_error_;          // of the object's diagonal; 0: all numbers
  const std::size_t budget_;             // of moves and traction of a message [bytes]
  const bool nodal_forces_, traction_;   // requested error
  std::vector<std::uint32_t> elements_;  // positions as known to the reader
  std::vector<float> rest_;              // traction as known to the reader
  std::vector<double> areas_;            // of its nodes, at rest [m^2]; 0 on an outline
  ShapeEncoder encoder_;
};

}  // namespace palpate
