// True contact of a round or tilted tool: bonded where it touches, without tension. All nodes that
// it may touch are condensed into one matrix; the contact set is determined for every tool
// position.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/reference/planar/patch_solution.h"
#include "slave/scene/scene.h"

namespace palpate::simulation {

// `nodes`: that may touch, relative to the first contact point of the apex, at rest [m].
struct RoundTouch {
  Eigen::MatrixXd stiffness;  // K / (E t) [-]: force on node i (x, y) by displacement of j (x, y)
  std::vector<Eigen::Vector2d> nodes;
  Eigen::Vector2d normal_O{0, 0};  // outward, unit: the axis of a tool that is not tilted
  Tool tool;
};

// Like SolvePatch, with `round`. The tool is flat or round. Cost: a tenth of a second or some.
PatchSolution SolveUnderRound(const TrueBody& body, double poisson_ratio, Plane plane,
                              const BoundaryPlace& place, const Tool& tool);

// Displacements of the nodes under an apex that has moved by `displacement_O` [m] since its first
// contact, or is before it; the tool is turned by `tilt` [rad] about the apex, counter-clockwise.
// Both of 2 entries (x, y) per node, O.
struct RoundState {
  Eigen::VectorXd displacement;  // [m]
  Eigen::VectorXd force;         // of the tool on the body / (E t) [m]; zero where nothing touches
  [[nodiscard]] Eigen::Vector2d total() const {
    return force.reshaped(2, force.size() / 2).rowwise().sum();
  }
};
RoundState Touched(const RoundTouch& touch, const Eigen::Vector2d& displacement_O, double tilt);

// Equivalent of `wide` at this displacement [m], not zero: a solution as of a flat tool whose
// displacements and force are those of the round one there.
PatchSolution SecantAt(const PatchSolution& wide, const Eigen::Vector2d& displacement_O,
                       double tilt);

}  // namespace palpate::simulation
