// An outline of boundary elements as the few straight segments of a prism, cut where a tool ends.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/extruded/pressed_prism.h"
#include "slave/mesh/outline.h"

namespace palpate {

struct ToolOnOutline {
  std::vector<Eigen::Vector2d> points;  // O [m]
  std::vector<MeshSegment> segments;    // tags as Prism's
  std::array<Eigen::Vector2d, 2> ends;  // of the tool [m]
};

// Places a tool of `width` [m] around the point of `element` that is nearest to `p_O`. The contact
// ends at corners of the outline. Consecutive elements are merged into one segment if none deviates
// from it by more than a thousandth of the larger side. nullopt: the tool covers a fixed part.
std::optional<ToolOnOutline> PlaceTool(const BoundaryMesh& mesh,
                                       const std::vector<std::array<bool, 2>>& held, int element,
                                       const Eigen::Vector2d& p_O, double width);

}  // namespace palpate
