#include "slave/mechanics/tet_mesh.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "shared/mesh/node_merger.h"
#include "slave/mesh/mesh_census.h"
#include "slave/mesh/mesh_check.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kFlat = 1e-14;  // volume / longest edge^3 of a degenerate tetrahedron

void RequireVolumes(const SolidMesh& mesh) {
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double longest = 0;
    for (const auto& [i, j] : kTetEdges) {
      const int a = mesh.tets[t][Index(i)], b = mesh.tets[t][Index(j)];
      longest = std::max(longest, (mesh.nodes[Index(a)] - mesh.nodes[Index(b)]).norm());
    }
    if (SignedVolume(mesh, static_cast<int>(t)) > kFlat * longest * longest * longest) continue;
    throw std::invalid_argument("tetrahedron " + std::to_string(t) +
                                ": expected a volume > 0, it is flat or inverted");
  }
}

void AddFaces(TetMesh* mesh, EdgeMiddles* middle) {
  mesh->touch_surface.nodes = mesh->nodes;
  for (const auto& [a, b, c] : mesh->surface.triangles) {
    if (mesh->nodes_per_element == 4) {
      mesh->faces.push_back({a, b, c, -1, -1, -1});
      mesh->touch_surface.triangles.push_back({a, b, c});
      continue;
    }
    const int ab = (*middle)(a, b), bc = (*middle)(b, c), ca = (*middle)(c, a);
    mesh->faces.push_back({a, b, c, ab, bc, ca});
    for (const std::array<int, 3>& t :
         {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) {
      mesh->touch_surface.triangles.push_back(t);
    }
  }
}

}  // namespace

void RequireTets(const SolidMesh& mesh, const HeldNodes& held) {
  MeshReport report;
  IsReadable(mesh.nodes, mesh.tets, {}, &report);
  RequireSound(report);
  if (held.size() != mesh.nodes.size()) {
    throw std::invalid_argument("fixed nodes = " + std::to_string(held.size()) +
                                ": expected one per node, " + std::to_string(mesh.nodes.size()));
  }
  RequireVolumes(mesh);
}

TetMesh MakeTetMesh(const SolidMesh& mesh, int nodes_per_element, double unit) {
  TetMesh made;
  made.vertex_count = static_cast<int>(mesh.nodes.size());
  made.nodes_per_element = nodes_per_element;
  for (const auto& p : mesh.nodes) made.nodes.emplace_back(p / unit);
  EdgeMiddles middle(&made.nodes);
  for (const auto& tet : mesh.tets) {
    made.connectivity.insert(made.connectivity.end(), tet.begin(), tet.end());
    if (nodes_per_element == 4) continue;
    for (const auto& [a, b] : kTetEdges)
      made.connectivity.push_back(middle(tet[Index(a)], tet[Index(b)]));
  }
  made.modulus = mesh.modulus;
  made.surface.triangles = SurfaceOf(mesh).triangles;
  made.surface.nodes.assign(made.nodes.begin(), made.nodes.begin() + made.vertex_count);
  AddFaces(&made, &middle);
  return made;
}

HeldNodes HeldWithMiddles(const TetMesh& mesh, HeldNodes held) {
  held.resize(mesh.nodes.size(), {true, true, true});
  for (int e = 0; e < mesh.element_count(); ++e) {
    const auto nodes = mesh.element(e);
    for (std::size_t i = 4; i < nodes.size(); ++i) {
      const auto& [a, b] = kTetEdges[i - 4];
      const auto &ha = held[Index(nodes[Index(a)])], &hb = held[Index(nodes[Index(b)])];
      held[Index(nodes[i])] = {ha[0] && hb[0], ha[1] && hb[1], ha[2] && hb[2]};
    }
  }
  return held;
}

TetGeometry GeometryOf(const std::vector<Vector3d>& nodes, std::span<const int> tet) {
  const auto p = [&](std::size_t i) -> const Vector3d& { return nodes[Index(tet[i])]; };
  const Vector3d a = p(1) - p(0), b = p(2) - p(0), c = p(3) - p(0);
  const double six_volumes = a.dot(b.cross(c));
  TetGeometry geometry;
  geometry.volume = six_volumes / 6;
  geometry.grad.col(1) = b.cross(c) / six_volumes;
  geometry.grad.col(2) = c.cross(a) / six_volumes;
  geometry.grad.col(3) = a.cross(b) / six_volumes;
  geometry.grad.col(0) = -(geometry.grad.col(1) + geometry.grad.col(2) + geometry.grad.col(3));
  return geometry;
}

Lame LameOf(double nu) {
  return {0.5 / (1 + nu), nu / ((1 + nu) * (1 - 2 * nu))};
}

}  // namespace palpate
