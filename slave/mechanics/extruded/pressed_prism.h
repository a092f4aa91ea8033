// A linear-elastic prism that is moved by a rigid tool glued to its side. The finite elements are
// products of quadratic triangles in the plane and quadratic lines through the thickness. The mesh
// is made for this one tool, with small elements at its ends.
//
//   K = sum over components of plane integrals times integrals through the thickness
//
// Each entry of the stiffness is such a product. For a tool at the centre of the thickness only
// half of the prism is solved, by symmetry. Nondimensional: lengths are divided by some unit,
// forces by E times its square. Small strain, nu < 0.5.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "slave/mesh/graded_mesh.h"

namespace palpate {

struct Prism {
  // Flags of the outline's segments, added.
  static constexpr int kHeld = 1, kTool = 2;

  std::vector<Eigen::Vector2d> points;
  std::vector<MeshSegment> segments;  // closed loops
  double thickness = 0;               // > 0
  double front = 0, depth = 0;        // from the front face to the tool, and the tool's extent
  double poisson_ratio = 0;
};

// Excess width by which a discretised rigid tool acts wider at each end: the stress is singular
// there, and the elements reach beyond the end by a part of their length. Reduce the ends of
// `tool`, and `front` and `depth` below, by this excess.
struct EndExcess {
  double along = 0, through = 0;  // the outline, the thickness
};
// `prism` with the true extent of a tool of `width`.
EndExcess ExcessOf(const Prism& prism, double width);

struct PressedPrism {
  // Force on the tool per unit displacement along x and y. The tool does not turn and does not move
  // through the thickness.
  Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();
  // Displacement of the front face at the requested places, per unit displacement of the tool along
  // x and y; z points out of the face.
  std::array<std::vector<Eigen::Vector3d>, 2> front;
  int unknowns = 0, elements = 0;
};

// `tool`: its two ends on the outline. `places`: on the outline or inside. Supports that fix x and
// y also fix z. Throws std::invalid_argument: the tool covers a support, or nothing holds the body;
// std::runtime_error as MakeGradedMesh.
PressedPrism PressPrism(const Prism& prism, const std::array<Eigen::Vector2d, 2>& tool,
                        const std::vector<Eigen::Vector2d>& places);

}  // namespace palpate
