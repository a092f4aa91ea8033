// The mesh of every volume model: straight-edged tetrahedra with four nodes (linear displacement)
// or ten (quadratic), their geometry at rest, and the moduli of an isotropic material.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mesh/index.h"

namespace palpate {

// Corners of a tetrahedron's edges, in the order of their mid-edge nodes.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
constexpr int kMaxNodes = 10;  // of one element

// Requirements of a mesh and its supports. Throws std::invalid_argument: no tetrahedron,
// coordinates that are not finite, a node that does not exist, `held` not one entry per node, a
// tetrahedron (named by its number) whose volume is not above 1e-14 of its longest edge cubed.
void RequireTets(const SolidMesh& mesh, const HeldNodes& held);

// How elements represent the displacement, and whether the pressure is an unknown of its own.
enum class Elements : std::uint8_t { kFourNodes, kFourNodesMixed, kTenNodes };

// Elements with ten nodes: the corners, then the mid-edge nodes.
struct TetMesh {
  // Those of the SolidMesh first, then the mid-edge nodes [unit].
  std::vector<Eigen::Vector3d> nodes;
  int vertex_count = 0;
  int nodes_per_element = 4;
  std::vector<int> connectivity;  // element by element
  std::vector<double> modulus;    // see SolidMesh
  SurfaceMesh surface;            // linear triangles over the vertices [unit]
  SurfaceMesh touch_surface;      // over all nodes: four triangles per linear one with ten nodes
  // Per linear triangle: corners, mid-edge nodes 01 12 20 (or -1).
  std::vector<std::array<int, 6>> faces;

  [[nodiscard]] int node_count() const { return static_cast<int>(nodes.size()); }
  [[nodiscard]] int element_count() const {
    return static_cast<int>(connectivity.size()) / nodes_per_element;
  }
  [[nodiscard]] double ModulusOf(int e) const { return modulus.empty() ? 1 : modulus[Index(e)]; }
  [[nodiscard]] std::span<const int> element(int e) const {
    const auto n = Index(nodes_per_element);
    return std::span(connectivity).subspan(n * Index(e), n);
  }
};

// Lengths are divided by `unit` [m]. The mesh is as RequireTets requires.
TetMesh MakeTetMesh(const SolidMesh& mesh, int nodes_per_element, double unit);

// Extends `held` from the vertices to all nodes of `mesh`: a mid-edge node is fixed if both ends of
// its edge are.
HeldNodes HeldWithMiddles(const TetMesh& mesh, HeldNodes held);

// Gradients of the volume coordinates, one per corner, and the volume of one element at rest.
struct TetGeometry {
  Eigen::Matrix<double, 3, 4> grad;
  double volume = 0;
};
TetGeometry GeometryOf(const std::vector<Eigen::Vector3d>& nodes, std::span<const int> tet);

// Lame's moduli by Young's modulus [-].
struct Lame {
  double mu = 0, lambda = 0;
};
// -1 < nu < 0.5.
Lame LameOf(double nu);

}  // namespace palpate
