// A uniform load over a disc on a triangulated surface, the same on every mesh: no whole triangles,
// no whole nodes.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate::study {

struct LoadPoint {
  Eigen::Vector3d p_O{0, 0, 0};  // on the triangle [m]
  int triangle = -1;
  double share = 0;  // of the load; all of them sum up to 1
};

// Points whose loads do the work of a load spread evenly over all that lies within width / 2 of
// `p_O` and faces against `inward_O` (within 60 degrees, so that a thin object is pushed on one
// side). Exact where the displacement is linear within a triangle, but for the edge of the disc,
// which is cut out in steps of a 64th of the triangles' edges; with `quadratic` also where it is a
// parabola: then the points are the six nodes, and some shares are negative. Empty: nothing lies
// there.
std::vector<LoadPoint> RoundLoad(const SurfaceMesh& surface, const Eigen::Vector3d& p_O,
                                 const Eigen::Vector3d& inward_O, double width, bool quadratic);

}  // namespace palpate::study
