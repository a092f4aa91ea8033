// Straight-edged tetrahedra with four nodes (linear displacement) or ten (quadratic).
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/scene/scene.h"

namespace palpate {

constexpr int kMaxNodes = 10;  // of one element

// Ten nodes: the corners, then the middles of the edges.
struct ElementMesh {
  std::vector<Eigen::Vector3d> nodes;  // those of the SolidMesh first, then the middles [unit]
  int vertex_count = 0;
  int nodes_per_element = 4;
  std::vector<int> connectivity;  // element by element
  std::vector<double> modulus;    // see SolidMesh
  SurfaceMesh surface;            // of linear triangles over the vertices
  SurfaceMesh touch_surface;      // over all nodes: four triangles per linear one with ten nodes
  std::vector<std::array<int, 6>> faces;  // per linear triangle: corners, middles 01 12 20 (or -1)

  [[nodiscard]] int node_count() const { return static_cast<int>(nodes.size()); }
  [[nodiscard]] int element_count() const {
    return static_cast<int>(connectivity.size()) / nodes_per_element;
  }
  [[nodiscard]] double ModulusOf(int e) const {
    return modulus.empty() ? 1 : modulus[static_cast<std::size_t>(e)];
  }
  [[nodiscard]] std::span<const int> element(int e) const {
    const auto n = static_cast<std::size_t>(nodes_per_element);
    return std::span(connectivity).subspan(n * static_cast<std::size_t>(e), n);
  }
};

// Lengths are divided by `unit` [m]. Throws std::invalid_argument: no tetrahedron, a node number or
// a coordinate that is none, a tetrahedron (named by its number) without positive volume.
ElementMesh MakeElementMesh(const SolidMesh& mesh, FemOptions::Element element, double unit);

// Gradients of the barycentric coordinates and the volume of one element at rest.
struct TetGeometry {
  Eigen::Matrix<double, 3, 4> grad;
  double volume = 0;
};
TetGeometry GeometryOf(const ElementMesh& mesh, int element);

// A rule on the tetrahedron, weights add up to one: one point is exact for four nodes, four points
// (degree 2) for the linear stiffness of ten.
struct QuadraturePoint {
  Eigen::Vector4d bary;
  double weight = 0;
};
std::span<const QuadraturePoint> QuadratureOf(int nodes_per_element);

using ShapeValues = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxNodes, 1>;
ShapeValues ShapesAt(int nodes_per_element, const Eigen::Vector4d& bary);

// Integrals of shape functions over an element of volume one: of each, and of products of two.
ShapeValues ShapeIntegrals(int nodes_per_element);
Eigen::MatrixXd ShapeProducts(int nodes_per_element);

}  // namespace palpate
