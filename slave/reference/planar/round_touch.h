// True contact of a round or tilted tool: bonded where it touches, without tension. All nodes that
// it may touch are condensed into one matrix; the contact set is determined for every tool
// position.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/reference/planar/patch_solution.h"
#include "slave/scene/scene.h"

namespace palpate::simulation {

// `nodes`: that may touch, relative to the first contact point, at rest [m].
struct RoundTouch {
  Eigen::MatrixXd stiffness;  // K / (E t) [-]: force on node i (x, y) by displacement of j (x, y)
  std::vector<Eigen::Vector2d> nodes;
  Eigen::Vector2d normal_O{0, 0};  // outward there, unit
  Tool tool;
};

// Like SolvePatch, with `round`. The tool is flat or round. Cost: some tenths of a second.
PatchSolution SolveUnderRound(const TrueBody& body, double poisson_ratio, Plane plane,
                              const BoundaryPlace& place, const Tool& tool);

// Displacements of the nodes under a tool. Along the normal `displacement_O` [m] is that of the
// centre of a round end, or of the midpoint of a flat face, since its first contact; across it,
// that of the tool's point that touched first. `turn` is a counter-clockwise rotation [rad]: of a
// round end since the first contact, about its centre; of a flat face relative to the boundary,
// about its midpoint. Both results have 2 entries (x, y) per node, O.
struct RoundState {
  Eigen::VectorXd displacement;  // [m]
  Eigen::VectorXd force;         // of the tool on the body / (E t) [m]; zero without contact
  [[nodiscard]] Eigen::Vector2d total() const {
    return force.reshaped(2, force.size() / 2).rowwise().sum();
  }
};
RoundState Touched(const RoundTouch& touch, const Eigen::Vector2d& displacement_O, double turn);

// Returns the secant solution at this nonzero displacement [m]: one of a flat tool whose
// displacements and force are those of the round tool there.
PatchSolution SecantAt(const PatchSolution& wide, const Eigen::Vector2d& displacement_O,
                       double turn);

}  // namespace palpate::simulation
