// Checks of a mesh: whether it is usable, and fine enough for a contact; otherwise results are
// extrapolated. Two ways to fail: a contact's disc covers too few pieces, or four-node tetrahedra
// do not follow the strain (across a thin part that bends they are far too stiff: shear locking).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/solid_mesh.h"

namespace palpate {

// Requirements of the elements. All throw std::invalid_argument: no tetrahedron, coordinates that
// are not finite, a node that does not exist; a tetrahedron whose volume is not above `least` of
// its longest edge cubed; `held` not one entry per node.
void RequireReadable(const SolidMesh& mesh);
void RequireVolumes(const SolidMesh& mesh, double least);
void RequireOnePerNode(const HeldNodes& held, const SolidMesh& mesh);

// The pieces of a mesh that represent a contact's disc.
enum class PatchBasis : std::uint8_t {
  kMovedNodes,         // of four-node tetrahedra
  kMovedNodes10,       // of ten-node ones, those on edges too
  kLoadedTriangles,    // a uniform load on the nodes of four-node tetrahedra
  kLoadedTriangles10,  // of ten-node ones
  kTractionTriangles   // constant traction each: bem3d
};
struct PatchCover {
  PatchBasis basis = PatchBasis::kMovedNodes;
  DiscShare disc;   // the true contact
  double area = 0;  // tributary areas of the nodes, or areas of the triangles [m^2]
  int count = 0;    // of nodes, or of triangles
};
PatchCover CoverOf(const DiscPatch& patch, PatchBasis basis) noexcept;

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
// Least part of a point contact's weight on free nodes [-]: they alone take its displacement,
// divided by this part.
inline constexpr double kLeastFreeWeight = 0.5;
inline constexpr std::string_view kOnSupport =
    "the contact lies mostly on fixed nodes: the others move more than twice as far";
inline constexpr std::string_view kCoarsePatch =
    "the mesh is too coarse for a contact of this width here: the stiffness error is about 10 % or "
    "more";

// How much softer the body would be, were every edge free to bow:
//
//   eta^2 / 2U,   eta^2 = sum over edges |r|^2 / k,   r = sum_e V S (grad l_i + grad l_j)
//
// r is what the edge's quadratic shape 4 l_i l_j feels of the stresses S of the elements around it,
// k its own stiffness (mean over directions), U the energy of strain: a hierarchical error estimate
// with a diagonal (Bank and Smith 1993; Zienkiewicz, Gago and Kelly 1983). S is the second
// Piola-Kirchhoff stress, E and lengths nondimensional, so that rotations do not count. Edges of
// the elements at contacts are left out: there the patch decides.
class StrainResolution {
 public:
  // `held`: per node and component; edges do not bow along components that are fixed at both ends.
  // Poisson's ratio is limited to 0.49: locking beyond it is reported elsewhere.
  StrainResolution(const SolidMesh& mesh, const HeldNodes& held, double poisson_ratio);

  // For nodal displacements `u`, in the mesh's unit of length; `touched`: nodes of contacts. 0
  // without strain. O(elements), no allocation.
  double Softness(std::span<const Eigen::Vector3d> u, std::span<const int> touched) noexcept;

 private:
  struct Element {
    std::array<int, 4> nodes{};
    std::array<int, 6> edges{};
    Eigen::Matrix<double, 3, 4> gradients;
    double volume = 0;
  };
  void Number(const HeldNodes& held);
  void AddElement(const Element& element, std::span<const Eigen::Vector3d> u) noexcept;
  void MarkContacts(std::span<const int> touched) noexcept;

  double lambda_, mu_;  // by E
  std::vector<Element> elements_;
  std::vector<std::array<int, 2>> ends_;     // per edge
  std::vector<Eigen::Vector3d> compliance_;  // 1 / k per edge and component; 0: fixed
  std::vector<Eigen::Vector3d> residual_;
  std::vector<char> near_;  // per node: one in contact, or of an element that has one
  double twice_energy_ = 0;
};

// Beyond it a solution is extrapolated.
inline constexpr double kMostSoftness = 0.1;
inline constexpr std::string_view kStiffInBending =
    "too few linear tetrahedra across a part that bends: its stiffness is too high by about 10 % "
    "or more";

}  // namespace palpate
