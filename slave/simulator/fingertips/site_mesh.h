// Meshes of the simulated body, finer near the fingers: quadratic hexahedra for boxes, cubic
// tetrahedra for mesh files. No estimator uses such elements.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/reference/solid/element_shape.h"
#include "slave/scene/scene.h"

namespace palpate {

// Resolution of the true body's mesh.
struct SiteResolution {
  double edge = 1e-3;            // between the nodes of boxes, where fingers touch [m]
  double fine_reach = 2e-3;      // distance from the focus up to which this edge length is used [m]
  double growth = 0.6;           // increase of the edge length per distance beyond `fine_reach` [-]
  int max_hexahedra = 225;       // of a box; above them all edges are made longer
  std::size_t max_tets = 20000;  // mesh files are refined, at most twice, within this
};

}  // namespace palpate

namespace palpate::simulation {

struct SiteMesh {
  std::vector<Eigen::Vector3d> nodes;  // p_O [m]
  std::shared_ptr<const ElementShape> shape;
  std::vector<std::vector<int>> elements;       // nodes, in the order of the shape's lattice
  std::vector<std::array<int, 3>> triangles{};  // between the nodes of the surface, outward
};

// Returns ends of hexahedra from 0 to `length`, spaced as `resolution` requires around `focuses`.
// They include the focuses that are inside, and `others`. `hexahedra`: exactly this number, 0: as
// many as needed. If it is too small for the required ends, these ends alone.
struct AxisGrading {
  double length = 0;  // [m], > 0
  std::vector<double> focuses, others;
};
std::vector<double> GradedAxis(const AxisGrading& axis, const SiteResolution& resolution,
                               int hexahedra = 0);

// A box over three axes' ends.
SiteMesh MeshGradedBox(const std::array<std::vector<double>, 3>& axes);
constexpr int kHexahedronDegree = 2;

// A mesh file's own tetrahedra. Throws std::invalid_argument: no volume, an unusable file.
SolidMesh OwnMesh(const Geometry& geometry);
// Makes cubic elements if there are few, else linear ones, refined at most twice within `max_tets`.
// Large files are not refined; then the simulator uses the same mesh as `fem`, with another
// constitutive law.
SiteMesh MeshTetrahedra(const SolidMesh& mesh, std::size_t max_tets);

}  // namespace palpate::simulation
