#include "shared/mesh/solid_mesh.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "shared/mesh/node_merger.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<int, 3>;

constexpr std::int64_t kMaxTets = 4'000'000;

// Faces of a tetrahedron with positive volume, with outward normals.
constexpr std::array<Triangle, 4> kFaces{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};

// The cube's six tetrahedra along its diagonal, corner c = dx + 2 dy + 4 dz.
constexpr std::array<std::array<int, 4>, 6> kCellTets{
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

Triangle Sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

// Returns the edge lengths of the bounding box.
Eigen::Vector3d BoxOf(const std::vector<Eigen::Vector3d>& nodes) {
  if (nodes.empty()) return Eigen::Vector3d::Zero();
  Eigen::AlignedBox3d box;
  for (const auto& p : nodes) box.extend(p);
  return box.sizes();
}

}  // namespace

SurfaceMesh SurfaceOf(const SolidMesh& mesh) {
  std::map<Triangle, int> uses;
  for (const auto& tet : mesh.tets) {
    for (const auto& [a, b, c] : kFaces) {
      ++uses[Sorted({tet[static_cast<std::size_t>(a)], tet[static_cast<std::size_t>(b)],
                     tet[static_cast<std::size_t>(c)]})];
    }
  }
  SurfaceMesh surface{mesh.nodes, {}};
  for (const auto& tet : mesh.tets) {
    for (const auto& [a, b, c] : kFaces) {
      const Triangle face{tet[static_cast<std::size_t>(a)], tet[static_cast<std::size_t>(b)],
                          tet[static_cast<std::size_t>(c)]};
      if (uses[Sorted(face)] == 1) surface.triangles.push_back(face);
    }
  }
  return surface;
}

SolidMesh MeshBox(const Vector3d& size, const std::array<int, 3>& cells) {
  const auto [n_x, n_y, n_z] = cells;
  if (!(size.minCoeff() > 0) || !size.allFinite()) {
    throw std::invalid_argument("box size: expected three finite lengths > 0");
  }
  if (n_x < 1 || n_y < 1 || n_z < 1 || n_x > kMaxTets || n_y > kMaxTets || n_z > kMaxTets ||
      6.0 * n_x * n_y * n_z > static_cast<double>(kMaxTets)) {
    throw std::invalid_argument("box cells: expected three counts >= 1, " +
                                std::to_string(kMaxTets) + " tetrahedra at most");
  }
  SolidMesh mesh;
  for (int k = 0; k <= n_z; ++k) {
    for (int j = 0; j <= n_y; ++j) {
      for (int i = 0; i <= n_x; ++i) {
        mesh.nodes.emplace_back(size.x() * i / n_x, size.y() * j / n_y, size.z() * k / n_z);
      }
    }
  }
  const auto id = [&](int i, int j, int k) { return i + (n_x + 1) * (j + (n_y + 1) * k); };
  for (int k = 0; k < n_z; ++k) {
    for (int j = 0; j < n_y; ++j) {
      for (int i = 0; i < n_x; ++i) {
        for (const auto& corners : kCellTets) {
          std::array<int, 4> tet{};
          for (std::size_t v = 0; v < 4; ++v) {
            const int c = corners[v];
            tet[v] = id(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
          }
          mesh.tets.push_back(tet);
          if (SignedVolume(mesh, static_cast<int>(mesh.tets.size()) - 1) < 0) {
            std::swap(mesh.tets.back()[2], mesh.tets.back()[3]);
          }
        }
      }
    }
  }
  return mesh;
}

SolidMesh Refined(const SolidMesh& mesh) {
  SolidMesh fine{mesh.nodes, {}};
  fine.tets.reserve(8 * mesh.tets.size());
  EdgeMiddles middle(&fine.nodes);
  for (const auto& [a, b, c, d] : mesh.tets) {
    const int ab = middle(a, b), ac = middle(a, c), ad = middle(a, d);
    const int bc = middle(b, c), bd = middle(b, d), cd = middle(c, d);
    // First the four tetrahedra at the corners, then the four of the inner octahedron about its
    // axis from ac to bd.
    for (const std::array<int, 4>& tet : {std::array{a, ab, ac, ad},
                                          {ab, b, bc, bd},
                                          {ac, bc, c, cd},
                                          {ad, bd, cd, d},
                                          {ac, bd, ab, bc},
                                          {ac, bd, bc, cd},
                                          {ac, bd, cd, ad},
                                          {ac, bd, ad, ab}}) {
      fine.tets.push_back(tet);
    }
  }
  for (int i = 0; i < static_cast<int>(fine.tets.size()); ++i) {
    auto& tet = fine.tets[static_cast<std::size_t>(i)];
    if (SignedVolume(fine, i) < 0) std::swap(tet[2], tet[3]);
  }
  for (const double modulus : mesh.modulus) fine.modulus.insert(fine.modulus.end(), 8, modulus);
  return fine;
}

SurfaceMesh Refined(const SurfaceMesh& mesh) {
  SurfaceMesh fine{mesh.nodes, {}};
  fine.triangles.reserve(4 * mesh.triangles.size());
  EdgeMiddles middle(&fine.nodes);
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const Triangle& t :
         {Triangle{a, ab, ca}, Triangle{ab, b, bc}, Triangle{ca, bc, c}, Triangle{ab, bc, ca}}) {
      fine.triangles.push_back(t);
    }
  }
  return fine;
}

double SignedVolume(const SolidMesh& mesh, int tet) {
  const auto& [a, b, c, d] = mesh.tets[static_cast<std::size_t>(tet)];
  const auto p = [&](int node) -> const Vector3d& {
    return mesh.nodes[static_cast<std::size_t>(node)];
  };
  return (p(b) - p(a)).dot((p(c) - p(a)).cross(p(d) - p(a))) / 6;
}

double Diagonal(const std::vector<Eigen::Vector3d>& nodes) {
  return BoxOf(nodes).norm();
}

double LargerSide(const std::vector<Eigen::Vector3d>& nodes) {
  return BoxOf(nodes).maxCoeff();
}

}  // namespace palpate
