// The truth of one contact: a rigid flat tool bonded to a patch of the boundary, displaced by one
// unit in x and in y. Every pose of the tool while the contact lasts is a sum of the two.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/site/camera/plane_elasticity.h"
#include "slave/site/camera/true_body.h"

namespace palpate::site {

// How fine the solution is, in parts of the body's larger side unless it says otherwise.
// The defaults give the contact stiffness within 1e-3 (tests/slave/site).
struct Fineness {
  double largest = 0.15;       // elements far from everything
  double growth = 0.4;         // of the element size with the distance from a seed
  double at_patch_end = 3e-4;  // elements at the patch's ends, in parts of the patch
  double at_support_end = 0.0005;
};

struct PatchSolution {
  QuadraticMesh mesh;         // in parts of the larger side, frame O
  Fields displacement;        // nodes x (x, y under unit x; x, y under unit y) [-]
  Eigen::Matrix2d stiffness;  // K / (E t) [-]: force of the tool on the body per displacement, O
  std::vector<int> boundary;  // nodes along the loops, one loop after another
  std::vector<std::size_t> loop_begin;  // loops + 1 entries
};

// `E` does not enter; nu and plane do. Throws std::runtime_error where no mesh fills the outline.
// Cost: 10 to 30 ms.
PatchSolution SolvePatch(const TrueBody& body, double poisson_ratio, Plane plane,
                         const BoundaryPlace& place, double width, const Fineness& fineness = {});

}  // namespace palpate::site
