// Fills a closed surface with tetrahedra, using the program TetGen or Gmsh. Both are separate
// programs (AGPL, GPL), which are found on PATH and never linked.
#pragma once

#include <chrono>
#include <cstdint>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

struct FillOptions {
  enum class Program : std::uint8_t { kFirstFound, kTetgen, kGmsh };  // TetGen is searched first

  double resolution = 0;  // edge of a tetrahedron [m]; 0: chosen by the program
  Program program = Program::kFirstFound;
  std::chrono::milliseconds timeout{120'000};
  MeshNumbers numbers;  // of the surface, for messages
};

// Triangles may have either orientation. TetGen keeps the surface's nodes as the first ones and
// adds nodes; Gmsh remeshes the surface if it has edges much longer than `resolution`. The result
// is checked: its volume is that of the surface within 2 %, every tetrahedron is positive and every
// node is used.
//
// Throws std::invalid_argument: `resolution` not finite or so small that more than 4 million
// tetrahedra are needed, a surface that is open, non-manifold or without inside;
// std::runtime_error: no program is installed, it failed (self-intersecting surface; its message is
// quoted), took too long or filled another volume; Interrupted: `stop` was requested.
SolidMesh FillSurface(const SurfaceMesh& surface, const FillOptions& options,
                      const std::stop_token& stop = {});

// Returns a point in every cavity of a closed surface that CheckMesh has oriented [m]: halfway
// along the normal of the cavity's largest triangle to the next triangle. O(parts x triangles).
std::vector<Eigen::Vector3d> HolePoints(const SurfaceMesh& surface);

}  // namespace palpate
