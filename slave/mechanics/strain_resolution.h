// Whether four-node tetrahedra follow the strain of an answer: across a thin part that bends they
// are far too stiff (shear locking).
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// How much softer the body would be, were every edge free to bow:
//
//   eta^2 / 2U,   eta^2 = sum over edges |r|^2 / k,   r = sum_e V S (grad l_i + grad l_j)
//
// r is what the edge's quadratic shape 4 l_i l_j feels of the stresses S of the elements around it,
// k its own stiffness (mean over directions), U the energy of strain: a hierarchical error estimate
// with a diagonal (Bank and Smith 1993; Zienkiewicz, Gago and Kelly 1983). S is the second
// Piola-Kirchhoff stress, E and lengths nondimensional, so that rotations do not count. Edges of
// the elements at contacts are left out: there the patch decides (mesh_resolution.h).
class StrainResolution {
 public:
  // `held`: per node and component; edges do not bow along what holds both their ends. Poisson's
  // ratio is taken as 0.49 at most: what locks beyond is told elsewhere.
  StrainResolution(const SolidMesh& mesh, const std::vector<std::array<bool, 3>>& held,
                   double poisson_ratio);

  // Of nodal displacements `u`, in the mesh's unit of length; `touched`: nodes of contacts. 0 where
  // nothing is strained.
  // O(elements), no allocation.
  double Softness(std::span<const Eigen::Vector3d> u, std::span<const int> touched) noexcept;

 private:
  struct Element {
    std::array<int, 4> nodes{};
    std::array<int, 6> edges{};
    Eigen::Matrix<double, 3, 4> gradients;
    double volume = 0;
  };
  void Number(const std::vector<std::array<bool, 3>>& held);
  void AddElement(const Element& element, std::span<const Eigen::Vector3d> u) noexcept;
  void MarkContacts(std::span<const int> touched) noexcept;

  double lambda_, mu_;  // by E
  std::vector<Element> elements_;
  std::vector<std::array<int, 2>> ends_;     // per edge
  std::vector<Eigen::Vector3d> compliance_;  // 1 / k per edge and component; 0: held
  std::vector<Eigen::Vector3d> residual_;
  std::vector<char> near_;  // per node: one that is touched, or of an element that has one
  double twice_energy_ = 0;
};

// Beyond it an answer is extrapolated.
inline constexpr double kMostSoftness = 0.1;
inline constexpr std::string_view kStiffInBending =
    "too few linear tetrahedra across a part that bends: too stiff by about 10 % or more";

}  // namespace palpate
