// Tetrahedra inside a closed surface, by the program TetGen or Gmsh. Both are programs of their own
// (AGPL, GPL), found on PATH and run as such, never linked.
#pragma once

#include <chrono>
#include <cstdint>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

struct FillOptions {
  enum class Program : std::uint8_t {
    kFirstFound,
    kTetgen,
    kGmsh
  };  // the search begins with TetGen

  double resolution = 0;  // edge of a tetrahedron [m]; 0: left to the program
  Program program = Program::kFirstFound;
  std::chrono::milliseconds timeout{120'000};
  MeshNumbers numbers;  // of the surface, for messages
};

// Triangles may face either way. TetGen keeps the surface's nodes, as the first ones, and adds to
// them; Gmsh divides the surface again if it has edges much longer than `resolution`. The mesh is
// checked, its volume is the surface's within 2 %, every tetrahedron is positive and every node
// used.
//
// Throws std::invalid_argument: `resolution` not finite or so small that 4 million tetrahedra would
// not do, a surface that is open, forked or without inside; std::runtime_error: no program there,
// one that failed (a surface that cuts itself; its own words are quoted), took too long or left
// another volume; Interrupted: `stop` was requested.
SolidMesh FillSurface(const SurfaceMesh& surface, const FillOptions& options,
                      const std::stop_token& stop = {});

// A point in every cavity of a closed surface that CheckMesh has turned [m]: half way along the
// normal of the cavity's largest triangle to the next triangle. O(parts x triangles).
std::vector<Eigen::Vector3d> HolePoints(const SurfaceMesh& surface);

}  // namespace palpate
