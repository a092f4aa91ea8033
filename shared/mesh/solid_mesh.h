// Volumes as tetrahedra and closed surfaces as triangles. Frame O [m].
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// Linear tetrahedra; quadratic ones (tet10) are made from them by the models that use them.
struct SolidMesh {
  std::vector<Eigen::Vector3d> nodes;    // p_O [m]
  std::vector<std::array<int, 4>> tets;  // det(p1 - p0, p2 - p0, p3 - p0) > 0
  // Young's modulus of every tetrahedron divided by the body's [-]; empty: 1.
  std::vector<double> modulus{};

  [[nodiscard]] double ModulusOf(std::size_t tet) const {
    return modulus.empty() ? 1 : modulus[tet];
  }
};

// Triangles are counter-clockwise seen from outside, so (p1 - p0) x (p2 - p0) points outwards.
struct SurfaceMesh {
  std::vector<Eigen::Vector3d> nodes;  // p_O [m]; of a volume all of its, inner ones too
  std::vector<std::array<int, 3>> triangles;
};

// HeldNodes flags the components x, y, z of each node or triangle that are fixed at zero.
using HeldNodes = std::vector<std::array<bool, 3>>;

// The faces that belong to one tetrahedron only, in the order of the tetrahedra, outward. Node
// numbers stay. O(N log N).
SurfaceMesh SurfaceOf(const SolidMesh& mesh);

// A box with its lower corner at the origin: nodes id = i + (n_x + 1) (j + (n_y + 1) k), every cell
// cut into six tetrahedra along the diagonal from corner 0 to corner 7, corner c = dx + 2 dy + 4 dz
// (`object.geometry.box`). Throws std::invalid_argument: sizes not positive and finite, no cell,
// more than 4 million tetrahedra.
SolidMesh MeshBox(const Eigen::Vector3d& size, const std::array<int, 3>& cells);

// Divides every tetrahedron into eight with the same modulus, and every triangle into four, at the
// midpoints of their edges. The old nodes come first.
SolidMesh Refined(const SolidMesh& mesh);
SurfaceMesh Refined(const SurfaceMesh& mesh);

// Signed volume of one tetrahedron [m^3].
double SignedVolume(const SolidMesh& mesh, int tet);
// Lengths of the bounding box's diagonal, and of its largest side [m]; 0: no nodes.
double Diagonal(const std::vector<Eigen::Vector3d>& nodes);
double LargerSide(const std::vector<Eigen::Vector3d>& nodes);

// Numbers of nodes and elements in the file, for messages.

// The file's number of node or element i; empty: the file counts from 0, or there is no file.
struct MeshNumbers {
  std::vector<std::int64_t> nodes, elements;

  [[nodiscard]] std::string Node(int i) const { return "node " + Name(nodes, i); }
  [[nodiscard]] std::string Element(int i) const { return "element " + Name(elements, i); }

 private:
  static std::string Name(const std::vector<std::int64_t>& numbers, int i) {
    return std::to_string(numbers.empty() ? i : numbers[static_cast<std::size_t>(i)]);
  }
};

}  // namespace palpate
