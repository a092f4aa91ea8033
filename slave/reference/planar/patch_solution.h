// The truth of one contact: a rigid flat tool bonded to a patch of the boundary, displaced by one
// unit in x and in y. Every pose of the tool while the contact lasts is a sum of the two.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mesh/graded_mesh.h"
#include "slave/reference/planar/plane_elasticity.h"
#include "slave/reference/planar/true_body.h"

namespace palpate::simulation {

// A body's edges for meshing: divided at the ends of the tool's contact, each piece marked as
// fixed, moved or free.
enum Tag : int { kHeld = 1, kPatch = 2 };

struct TaggedOutline {
  std::vector<Eigen::Vector2d> points;
  std::vector<MeshSegment> segments;
};

// The body's edges in parts of `unit` [m], divided at the ends of the patch: from and to along
// `loop` [m].
TaggedOutline Divide(const TrueBody& body, int loop, std::pair<double, double> patch, double unit);

struct RoundTouch;

// Resolution of the solution, relative to the body's larger side unless stated otherwise. The
// defaults give the contact stiffness within 1e-3 (tests/slave/reference).
struct Fineness {
  double largest = 0.15;       // elements far from everything
  double growth = 0.4;         // of the element size with the distance from a seed
  double at_patch_end = 3e-4;  // elements at the patch's ends, in parts of the patch
  double at_support_end = 0.0005;
};

struct PatchSolution {
  QuadraticMesh mesh;           // in parts of the larger side, frame O
  Fields displacement{};        // nodes x (x, y under unit x; x, y under unit y) [-]
  Eigen::Matrix2d stiffness{};  // K / (E t) [-]: force of the tool on the body per displacement, O
  std::vector<int> boundary{};  // nodes along the loops, one loop after another
  std::vector<std::size_t> loop_begin{};  // loops + 1 entries
  // Data of a round tool: nodes and columns of `displacement` as defined there, two unit cases per
  // node that may touch; `stiffness` is unknown. nullptr: a flat tool.
  std::shared_ptr<const RoundTouch> round{};
};
// Fills boundary and loop_begin from the mesh, every loop starting where its first edge was found.
void OrderBoundary(PatchSolution& solution);

// `E` does not enter; nu and plane do. Throws std::runtime_error where no mesh fills the outline.
// Cost: 10 to 30 ms.
PatchSolution SolvePatch(const TrueBody& body, double poisson_ratio, Plane plane,
                         const BoundaryPlace& place, double width, const Fineness& fineness = {});
// Solves the same tool without friction: every point of the contact moves along the unit vector
// `way_O` by the same amount, without force across it. Returns force per displacement along it, K /
// (E t) [-]. Throws std::runtime_error also if a support leaves one component free.
double SlidingStiffness(const TrueBody& body, double poisson_ratio, Plane plane,
                        const BoundaryPlace& place, double width, const Eigen::Vector2d& way_O,
                        const Fineness& fineness = {});

}  // namespace palpate::simulation
