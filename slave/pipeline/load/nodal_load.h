// A load over a disc as forces on the nodes of a surface.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// Spreads `force_O` [N] evenly over the disc of diameter `width` [m], 0: a point, around the
// surface's place p_O with normal n_O: at places of the disc, each taken to the nodes of its
// triangle, so that force and centre are kept. The forces are `f_O`, one per node. O(nodes).
void SpreadLoad(const SurfaceMesh& surface, const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O,
                double width, const Eigen::Vector3d& force_O, std::vector<Eigen::Vector3d>* f_O);

}  // namespace palpate
