// Whether a mesh is fine enough for what is asked of it: where it is not, answers are extrapolated.
#pragma once

#include <cstdint>
#include <string_view>

#include "shared/mesh/surface_patch.h"

namespace palpate {

// What stands for a contact's disc on a mesh.
enum class PatchBasis : std::uint8_t {
  kMovedNodes,         // of four-node tetrahedra
  kMovedNodes10,       // of ten-node ones, those on edges too
  kLoadedTriangles,    // a uniform load on the nodes of four-node tetrahedra
  kLoadedTriangles10,  // of ten-node ones
  kTractionTriangles   // constant traction each: bem3d
};
struct PatchCover {
  PatchBasis basis = PatchBasis::kMovedNodes;
  DiscShare disc;   // what is meant
  double area = 0;  // what the nodes stand for, or of the triangles [m^2]
  int count = 0;    // of nodes, or of triangles
};
PatchCover CoverOf(const SurfacePatch& patch, PatchBasis basis) noexcept;

// Stiffness of the patch by that of the disc on a half-space, estimated [-]; 0: nothing is touched,
// or fewer than three pieces of a disc.
//
// A half-space is as stiff under a disc as the disc is wide (flat punch: K = 2 E a / (1 - nu^2)):
// an area A in place of pi a^2 makes it sqrt(A / pi a^2) times as stiff, and n pieces add a share
// of c / sqrt(n) along the rim. c was fitted to cubes of 6 to 24 cells a side, nu 0 to 0.45, widths
// of 0.25 to 10 edges, places on nodes, cells and between: what is then within 10 % was within 13 %
// (loads on ten nodes: 16 %), and of what was within 6 % four in five are.
double PatchStiffness(const PatchCover& cover) noexcept;
// More than a tenth off.
bool IsPatchCoarse(const PatchCover& cover) noexcept;
inline constexpr std::string_view kCoarsePatch =
    "the mesh is too coarse for a patch of this width here: the stiffness is off by about 10 % or "
    "more";

}  // namespace palpate
