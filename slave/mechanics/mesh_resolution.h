// Determines whether a mesh is fine enough for a contact; otherwise results are extrapolated. There
// are two criteria: a contact's disc must cover enough pieces, and the tetrahedra must be able to
// represent the strain (otherwise bending parts are too stiff: shear locking).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/linear/lanes.h"
#include "slave/mechanics/tet_mesh.h"

namespace palpate {

// The pieces of a mesh that represent a contact's disc.
enum class PatchBasis : std::uint8_t {
  kMovedNodes,        // of four-node tetrahedra
  kMovedNodes10,      // of ten-node ones, those on edges too
  kLoadedTriangles,   // a uniform load on the nodes of four-node tetrahedra
  kLoadedTriangles10  // of ten-node ones
};
struct PatchCover {
  PatchBasis basis = PatchBasis::kMovedNodes;
  DiscShare disc;   // the true contact
  double area = 0;  // tributary areas of the nodes, or areas of the triangles [m^2]
  int count = 0;    // of nodes, or of triangles
};
PatchCover CoverOf(const DiscPatch& patch, PatchBasis basis) noexcept;

// Returns the estimated ratio of the stiffness of the patch to that of the disc on a half-space
// [-]; 0: no contact, or fewer than three pieces of a disc.
//
// The stiffness of a half-space is proportional to the width of the disc (flat punch: K = 2 E a /
// (1 - nu^2)): with an area A instead of pi a^2 it changes by sqrt(A / pi a^2), and n pieces add a
// fraction c / sqrt(n) along the rim. c was fitted to cubes of 6 to 24 cells a side, nu 0 to 0.45,
// widths of 0.25 to 10 edges, places on nodes, cells and between. Estimates within 10 % had true
// errors within 13 % (loads on ten nodes: 16 %); of true errors within 6 %, four in five have such
// estimates.
double PatchStiffness(const PatchCover& cover) noexcept;
// More than a tenth off.
bool IsPatchCoarse(const PatchCover& cover) noexcept;
// Returns the relative error of the compliance of such a disc [-]; 0: less than a tenth. With up to
// twenty-five nodes of ten-node tetrahedra, or five of four-node ones, the error may be 20 % for
// any area.
double PatchError(const PatchCover& cover) noexcept;
// Whether a contact's stiffness is more than a tenth off because its patch is. The disc's own
// compliance, 1 / (E width) on a half-space, is all of a contact's on a block and little of it on
// the end of a bar. `disc_stiffness`: E width [N/m].
bool IsContactCoarse(double patch_error, double disc_stiffness, const Eigen::Vector3d& force,
                     const Eigen::Vector3d& displacement) noexcept;
// Smallest part of a point contact's weight on free nodes [-]: only these get its displacement,
// divided by this part.
inline constexpr double kMinFreeWeight = 0.5;
inline constexpr std::string_view kOnSupport =
    "the contact lies mostly on fixed nodes: the others move more than twice as far";
inline constexpr std::string_view kCoarsePatch =
    "the mesh is too coarse for a contact of this width here: the stiffness error is about 10 % or "
    "more";

// Poisson's ratio from which four-node tetrahedra without a pressure unknown lock so much that the
// strains do not show it, under a tool, and at a point [-]. [measured: a disc of four elements on a
// box: 7 % too stiff at 0.4, 14 % at 0.45, 52 % at 0.489; at 0.47 what is left after the correction
// is 4 %, at 0.49 16 %]
inline constexpr double kLocks = 0.475, kLocksAtPoint = 0.4;
inline constexpr std::string_view kLocking =
    "four-node tetrahedra are too stiff at this Poisson's ratio: set model.element: tet10";

// Energy of the difference between recovered strains and those of the elements around a contact, by
// deviator and volume, relative to their strain energy [-].
struct MeshShare {
  double shear = 0, volume = 0;
};

// What a mesh changes in the force of a rigid tool, relative to it [-].
struct MeshEffect {
  double excess = 0;  // of the force; below zero: it is too small
  double error = 0;   // of the force without the excess
};

// How a tool holds the nodes that it touches.
struct ToolTouch {
  double spring_share = 0;  // ContactResponse::spring_share
  int touching = 0;         // nodes
};

// What the strains of the elements around a contact and the springs at its rim (rim_share.h) tell:
//
//   elements                  excess                                   error
//   four nodes                1.05 shear + 1.35 volume - 1.3 springs   0.25 shear + 0.5 volume
//   four nodes with pressure  0.9 shear - 0.55 springs                 0.5 shear
//   ten nodes                 0                                        0.5 shear
//
// Elements are too stiff by the energy that they lack; springs give way too much. The error has a
// quarter of the springs' work more. Under a tool whose rim has no springs, one of its n nodes more
// or less counts: 0.1 / sqrt(n), with ten nodes 0.25 / sqrt(n). Fitted to 48 presses on cylinders,
// layers, caps, half spheres and boxes (flat and round, sliding and glued, 4 to 15 elements across,
// uniform and graded; nu 0.2 to 0.4999, four nodes without pressure up to 0.47), with pressure to
// 65 more on meshes that are graded to the tool or grow from it, ten nodes to 24, against
// pressed_profile.py and pressed_box.py of the campaigns: what is left has a standard deviation of
// 1.9, 1.9 and 2.6 %.
MeshEffect EffectOf(const MeshShare& share, const ToolTouch& touch, Elements elements) noexcept;
// Removes the excess from a force with its moment and stiffness, and adds the error to its own.
void Correct(const MeshEffect& effect, ContactResponse* response) noexcept;
// Under a load with a width the displacement is too small by about the whole difference.
MeshEffect EffectOnLoad(const MeshShare& share) noexcept;

// Estimates how much softer the body would be on a finer mesh:
//
//   int (e* - e) : C : (e* - e) dV / int e : C : e dV
//
// e are the strains of the elements, e* the recovered strains: continuous, at a node the
// volume-weighted mean of the surrounding elements (Zienkiewicz and Zhu, Int. J. Numer. Meth. Eng.
// 24, 1987). The error of the energy is that of the compliance. e is E - E^2 / 2 of Green and
// Lagrange's strain E: it is independent of rotations, and to second order it is the stretch.
// Elements closer to contacts than the thickness are left out, because the body is compressed there
// and does not bend. The thickness is 4 V / A, the side of a long square bar. If no element is
// left, all are used. Bodies of up to two thicknesses, such as cubes, do not bend.
//
// Each element's energies are multiplied by its modulus. Strains jump where moduli do, so means are
// taken over elements of the same modulus, and no bar is searched.
//
// The recovered strains do not show an error that all elements around a node have in common. In a
// straight bar along a, farther than a quarter of the thickness from its supports, the solution is
// that of a beam (Saint-Venant): uniaxial stress along a, and shear along a. Restrained lateral
// strain makes an element stiffer, by q = r : C : r / E (a e a)^2 - 1, where r is e without the
// shear along a. Under the same stress it stores less energy: the missing part is its energy times
// q.
//
// If elements are too long to show the variation of the strain, it is assumed to fall linearly, as
// under a force at the end: of the energy beyond that of the mean strain, constant-strain elements
// of length h along a miss at least (h / 2 L)^2.
class StrainResolution {
 public:
  // Poisson's ratio is limited to 0.4999. `held`: per vertex of `mesh`; empty: the elements have
  // pressure unknowns, and no bar is searched.
  StrainResolution(const TetMesh& mesh, const HeldNodes& held, double poisson_ratio);

  // Sets the nodal displacements, middles too, in the mesh's unit of length. They must stay until
  // they are set again.
  void Take(std::span<const Eigen::Vector3d> u);
  // `touched`: nodes of contacts. 0 without strain. O(elements); O(nodes) more per node of new
  // contacts.
  double Softness(std::span<const int> touched);
  // A contact, in the mesh's unit.
  struct Touch {
    Eigen::Vector3d centre{0, 0, 0};
    double width = 0;
  };
  // The share of a contact, from the elements within one and a half of its widths. `number`: of the
  // contact; its elements are searched if it moved, O(elements). `work`: force times displacement
  // [E times the unit cubed].
  MeshShare ShareNear(std::size_t number, const Touch& touch, double work);
  // False: Softness is 0 for every contact.
  [[nodiscard]] bool body_bends() const { return slender_; }

 private:
  struct Element {
    std::array<int, 10> nodes{};
    TetGeometry geometry;
    double modulus = 1;
    double extent = 0;  // along the bar [the mesh's unit]
    double beam = 0;    // fraction of it where the bar is a beam [-]
  };
  // Components whose squares add up to twice a strain's energy: deviator, shear, volume.
  using Strain = Eigen::Matrix<double, 8, 1>;
  // Eight elements in lanes: the gradients of their four shape functions.
  using LaneGradients = std::array<fem::Double8, 12>;
  void PackGradients();
  void FindGradients(const Element& element, Eigen::Matrix3d* gradients) const noexcept;
  void FindStrains(std::size_t batch) noexcept;
  [[nodiscard]] double TwiceRestraint(const Strain& strain) const noexcept;
  // Elements whose strains are recovered together.
  struct Group {
    std::vector<int> elements;
    std::vector<std::array<int, 4>> means;  // per element: of its corners, in mean_
    std::vector<double> volumes, weights;   // per element; times its modulus
    std::vector<double> around;             // per mean: volume of its elements
  };
  struct Region {
    Touch touch{.width = -1};
    Group group;
  };
  void AddTo(int element, Group* group);
  void FindRegion(const Touch& touch, Region* region);
  void FindEnergiesOf(const Group& group) noexcept;
  double Bending(std::span<const int> touched);
  void FindBar(const HeldNodes& held);
  void NumberCorners();
  void MarkContacts(std::span<const int> touched);

  Lame lame_;
  double bulk_root_, shear_root_;  // of the moduli K and 2 mu [sqrt(E)]
  bool quadratic_;
  std::size_t corners_;  // vertices of the mesh
  bool slender_ = false;
  double thickness_ = 0, edge_ = 0;                     // edge: the mean one [the mesh's unit]
  Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();  // as rows; a straight bar's direction first
  double length_ = 0;                    // along it [the mesh's unit]; 0: it is no straight bar
  std::vector<Eigen::Vector3d> points_;  // nodes at rest, middles too
  std::vector<Element> elements_;
  std::vector<Eigen::Vector3d> centroids_;              // per element
  std::vector<std::array<int, 4>> corners_by_modulus_;  // per element: corners of one modulus
  std::vector<int> number_;                             // per corner of one modulus: in a group; -1
  Group all_;
  std::vector<Region> regions_;  // per contact
  std::span<const Eigen::Vector3d> u_;
  std::vector<LaneGradients> gradients_;         // per batch of eight elements with four nodes
  std::vector<std::array<int, 32>> lane_nodes_;  // of them, eight per corner
  // Strains at the corners of the elements, or one where all are equal, of the batches whose
  // strains at u_ are found.
  std::vector<Strain> strains_;
  std::vector<char> found_;
  // Of the last group: means of its strains, per corner node and modulus; twice the energies of e,
  // and of e* - e by deviator and volume, per element and volume.
  std::vector<Strain> mean_;
  std::vector<std::array<double, 3>> energies_;
  std::vector<int> touched_;  // last
  std::vector<char> near_;    // per element: a node is not farther from touched_ than thickness_
};

// Beyond it a solution is extrapolated.
inline constexpr double kMaxSoftness = 0.05;
inline constexpr std::string_view kStiffInBending =
    "too few tetrahedra for how the body bends: its stiffness is too high by about 5 % or more; "
    "use "
    "more cells or model.element = tet10";

}  // namespace palpate
