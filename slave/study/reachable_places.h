// Where a tool can press an object.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/scene/scene.h"

namespace palpate::study {

// Places where a tool of `width` [m] rests with all of it beside corners, edges and what is held,
// frame O [m]: one for each of the `shares`, numbers of [0, 1) that go evenly along the boundary
// where it rests, or over the surface in the order of its triangles, from where it does not rest on
// to other shares; of a membrane over all within 0.6 of the radius; of a shell opposite to what
// holds it. Empty: there is no such place. Throws std::invalid_argument: see MeshObject.
std::vector<Eigen::Vector3d> ReachablePlaces(const Scene& scene, double width,
                                             const std::vector<double>& shares);

// A share in each of `count` equal parts, each elsewhere in its part, so that neither a symmetry of
// the object nor its mesh repeats them.
std::vector<double> SpreadShares(int count);

}  // namespace palpate::study
