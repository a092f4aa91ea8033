// The truth of a round tool's contact: bonded where it touches, and it pulls nowhere. All nodes
// that it may touch are condensed into one matrix; which of them touch is found for every place of
// the tool.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/site/camera/patch_solution.h"

namespace palpate::site {

// The tool's end: a circle of `radius`, `width` across [m].
struct RoundEnd {
  double width = 0, radius = 0;
};

// `nodes`: that may touch, as they lie from the place where the apex first touched, at rest [m].
struct RoundTouch {
  Eigen::MatrixXd stiffness;  // K / (E t) [-]: force on node i (x, y) by displacement of j (x, y)
  std::vector<Eigen::Vector2d> nodes;
  Eigen::Vector2d normal_O{0, 0};  // outward, unit: the tool's axis
  double radius = 0;               // [m]
};

// Like SolvePatch, with `round`. Cost: a tenth of a second or some.
PatchSolution SolveUnderRound(const TrueBody& body, double poisson_ratio, Plane plane,
                              const BoundaryPlace& place, const RoundEnd& tool);

// What the nodes do under an apex that has moved by `displacement_O` [m] since it touched. Both of
// 2 entries (x, y) per node, O.
struct RoundState {
  Eigen::VectorXd displacement;  // [m]
  Eigen::VectorXd force;         // of the tool on the body / (E t) [m]; zero where nothing touches
  [[nodiscard]] Eigen::Vector2d total() const {
    return force.reshaped(2, force.size() / 2).rowwise().sum();
  }
};
RoundState Touched(const RoundTouch& touch, const Eigen::Vector2d& displacement_O);

// What `wide` comes to at this displacement [m], not zero: a solution as of a flat tool whose
// displacements and force are those of the round one there.
PatchSolution SecantAt(const PatchSolution& wide, const Eigen::Vector2d& displacement_O);

}  // namespace palpate::site
