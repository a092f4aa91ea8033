// The mesh of a scene's object, on which its model computes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mesh/files/mesh_file.h"
#include "slave/mesh/outline.h"
#include "slave/scene/scene.h"

namespace palpate {

// A round clamped membrane: closed forms and series need no mesh. Frame O: origin at the centre, z
// along the outward normal.
struct MembraneDisc {
  double radius = 0, thickness = 0;  // [m]
};

using ObjectMesh = std::variant<BoundaryMesh, MembraneDisc, SolidMesh>;

// The mesh of a file or in memory, not yet checked: CheckMesh. Throws std::invalid_argument as
// ReadMeshFile.
MeshFile ReadMesh(const MeshFileGeometry& geometry);
// Meshes the scene's object: an outline into model.elements elements, a box into its cells, a mesh
// from its file, the last two refined model.refinements times; a surface is filled with tetrahedra.
// A tetrahedron has the modulus of the last region that contains its
// centroid. `seen`: the outline found by the cameras, used for `contour: from-image`. Throws
// std::invalid_argument: a missing outline, fewer than three elements, an unusable mesh file, a
// region without a tetrahedron (file:line); std::runtime_error: a surface that no mesher could
// fill.
ObjectMesh MeshObject(const Scene& scene, const std::optional<Outline>& seen);
// Meshes a planar object; throws std::invalid_argument for others.
BoundaryMesh MeshOutline(const Scene& scene, const std::optional<Outline>& seen);
// The surface of a volume; empty for others.
SurfaceMesh SurfaceOf(const ObjectMesh& mesh);

// A length that no contact on the object is wider than [m]: the diagonal, or twice the larger side.
double SizeOf(const ObjectMesh& mesh);

// The surface of an object on which contacts are possible (rules: slave/solve/README.md).
class TouchableSurface {
 public:
  // Stores a reference to the mesh. O(N log N) for a volume.
  explicit TouchableSurface(const ObjectMesh& mesh);
  // Distance of `p_O` from the surface of a volume or from an outline; 0 on a membrane [m].
  // nullopt: the object cannot be touched there, and `accepted` states where it can, as text that
  // follows `expected`. O(N).
  [[nodiscard]] std::optional<double> Distance(const Eigen::Vector3d& p_O,
                                               std::string* accepted) const;

 private:
  const ObjectMesh& mesh_;
  SurfaceMesh skin_;  // of a volume
};

// Whether nodes or elements are fixed by number: then the numbers belong to one mesh.
bool HoldsByNumber(const Scene& scene);
// The components that object.fixed fixes, of every element (2D) or node (3D). Throws
// std::invalid_argument: an entry without any of them, a node that does not exist.
std::vector<std::array<bool, 2>> FixedElementDofs(const Scene& scene, const BoundaryMesh& mesh);
HeldNodes FixedNodeDofs(const Scene& scene, const std::vector<Eigen::Vector3d>& nodes);

// Fixed vertices of an object's drawing, along one axis at least: of an outline both ends of such
// elements, element i beginning at vertex i; of a surface its nodes, of a membrane its rim. Throw
// as above.
std::vector<std::uint32_t> HeldVertices(const Scene& scene, const BoundaryMesh& mesh);
std::vector<std::uint32_t> HeldVertices(const Scene& scene, const SurfaceMesh& surface);

}  // namespace palpate
