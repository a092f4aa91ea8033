// What the neighbours of a point say of the surface there.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/study/clouds/point_tree.h"

namespace palpate::study {

struct NeighbourhoodShape {
  // Where the neighbours' centroid lies, as a share of the radius: beside the point, 0 to 1, 0.42
  // on a straight edge where the surface ends; in front of it along the normal, which points to the
  // pupil, -1 to 1, 0.30 in a right-angled groove, negative on ridges.
  double beside = 0, before = 0;
  std::size_t neighbours = 0;
};

// `radius` [m] is that of the neighbourhood; the pupil is at the origin. O(N neighbours).
std::vector<NeighbourhoodShape> LookAround(std::span<const Eigen::Vector3d> points,
                                           const PointTree& tree, double radius);

}  // namespace palpate::study
