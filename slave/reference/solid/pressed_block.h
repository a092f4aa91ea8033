// The truth of a rigid flat tool, glued to a rectangular block, that reaches through a part of the
// block's thickness: linear elasticity in bricks of 27 nodes, graded to the tool's ends.
#pragma once

#include "slave/reference/planar/patch_solution.h"
#include "slave/reference/planar/true_body.h"
#include "slave/scene/scene.h"

namespace palpate::simulation {

// The solution's mesh and displacements are those of the front face, and its stiffness K / (E t) is
// that of the block, t its thickness. The tool neither moves through the thickness nor rotates.
// Within 2 % of the continuum. Throws std::invalid_argument: no rectangle, a partly fixed side;
// std::runtime_error: no solution. Cost: seconds.
PatchSolution SolveBlock(const TrueBody& body, double poisson_ratio, double thickness,
                         const BoundaryPlace& place, const Tool& tool);

}  // namespace palpate::simulation
