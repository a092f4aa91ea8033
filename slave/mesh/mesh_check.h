// Checks a mesh: corrections, warnings and refusals.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// The parts of a closed surface, and which of them are inside others.
//
// A part consists of triangles that are connected by edges. Parts that share only a node are
// separate.
struct SurfacePart {
  std::vector<int> triangles;
  int depth = 0;  // number of other parts around it; odd: it bounds a cavity
};
// Parts of a surface without open edges. Empty: more than kMaxParts. O(parts x triangles).
constexpr std::size_t kMaxParts = 1000;
std::vector<SurfacePart> ClosedParts(const SurfaceMesh& surface);

// Winding number of the triangles around `p` (unsigned; sum of their solid angles over 4 pi): 1
// inside a simple closed part, 0 outside. Source: van Oosterom and Strackee, IEEE Trans. Biomed.
// Eng. 30 (1983) 125-126, eq. 8.
double WindingNumber(const SurfaceMesh& surface, const std::vector<int>& triangles,
                     const Eigen::Vector3d& p);

// Volume enclosed by triangles that point outward [m^3].
double EnclosedVolume(const SurfaceMesh& surface, const std::vector<int>& triangles);

// Indices start at 0. Texts use the numbers of the file. An element is a tetrahedron, or a triangle
// of a surface.
struct MeshReport {
  bool solid = true;
  int nodes = 0, elements = 0;
  Eigen::Vector3d low_O{0, 0, 0}, high_O{0, 0, 0};  // bounding box of the elements' nodes [m]
  double volume = 0;  // volume of the tetrahedra, or enclosed by the surface (signed) [m^3]
  double area = 0;    // of the boundary [m^2]
  int parts = 0;      // number of parts without common nodes
  // Tetrahedra: 6 sqrt(2) V / L^3, triangles: 4 / sqrt(3) A / L^2, L the longest edge; 1: regular.
  double quality_min = 0, quality_median = 0;
  double aspect_max = 0;  // longest edge / smallest height
  // Inverted elements, corrected by swapping their last two nodes.
  std::vector<int> inverted;
  std::vector<int> slivers;         // quality below kSliver
  std::vector<int> dangling_nodes;  // used by no element; a stiffness matrix has zero rows there
  std::vector<int>
      duplicate_nodes;   // at the position of an earlier one: the parts are not connected
  int open_edges = 0;    // of one triangle only; a volume's boundary has none
  int forked_edges = 0;  // of three or more boundary triangles
  std::vector<std::string> warnings;
  std::vector<std::string> refusals;  // empty: the mesh can be used

  static constexpr double kSliver = 0.05;
};

// Corrects inverted elements and reports. Refused are: no element, node numbers out of range,
// coordinates that are not finite, elements without volume or area (relative to their edges and to
// the rounding of their coordinates), elements twice, faces of three tetrahedra, tetrahedra on the
// same side of their common face, and of surfaces edges that are open, forked or one-sided.
// Surfaces are oriented outward, and cavities toward their inside. `unit_given`: the user has set
// the unit, so that an unusual size causes no warning. O(N log N).
MeshReport CheckMesh(SolidMesh& mesh, const MeshNumbers& numbers = {}, bool unit_given = false);
MeshReport CheckMesh(SurfaceMesh& mesh, const MeshNumbers& numbers = {}, bool unit_given = false);

// The lines that `check` prints.
std::vector<std::string> Lines(const MeshReport& report);
// Throws std::invalid_argument with the first refusal, if any.
void RequireSound(const MeshReport& report);

}  // namespace palpate
