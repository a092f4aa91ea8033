// What one reader of WatchMesh is told: the topology once, then places, as numbers or as moves.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "shared/wire/shape_code.h"
#include "slave/pipeline/sense.h"

namespace palpate {

class MeshTeller {
 public:
  // Throws std::invalid_argument: `relative_error`, and what is accepted.
  explicit MeshTeller(const v1::WatchMeshRequest& request);
  // Overwrites `message`.
  void Tell(const BoundaryShape& shape, v1::MeshState* message);

 private:
  void Shorten(const BoundaryShape& shape, v1::MeshState* message);

  const double relative_error_;          // of the object's diagonal; 0: all numbers
  const std::size_t budget_;             // of the moves of a message [bytes]
  std::vector<std::uint32_t> elements_;  // as the reader knows them
  std::vector<float> rest_;              // likewise
  ShapeEncoder encoder_;
};

}  // namespace palpate
