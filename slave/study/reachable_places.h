// Points where a tool can touch an object.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/scene/scene.h"

namespace palpate::study {

// Points where a tool of `width` [m] fits completely between corners, edges and fixed parts, frame
// O [m]: one for each of the `shares`, numbers of [0, 1), spread evenly along the boundary or over
// the surface in the order of its triangles; a share where it does not fit is replaced by another
// one. For a membrane over all within 0.6 of the radius. Empty:
// there is no such point. Throws std::invalid_argument: see MeshObject.
std::vector<Eigen::Vector3d> ReachablePlaces(const Scene& scene, double width,
                                             const std::vector<double>& shares);

// Returns one position in each of `count` equal parts of [0, 1], at a different position within
// each part, so that no symmetry of the object or its mesh repeats them.
std::vector<double> SpreadShares(int count);

// Returns the contacts of a study of a whole object: if the scene names none, several that are
// spread evenly over all ReachablePlaces. Empty: the study's default. It is also empty for mesh
// files with more than 3000 tetrahedra or a round tool, which would take minutes, and for nodes
// that are fixed by number.
std::vector<Eigen::Vector3d> PlacesToStudy(const Scene& scene);

}  // namespace palpate::study
