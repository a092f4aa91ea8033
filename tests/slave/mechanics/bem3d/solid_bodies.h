// Surfaces of bodies whose elastostatics are known.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/solid_mesh.h"

namespace palpate::solid_bodies {

using Held = std::vector<std::array<bool, 3>>;

inline SurfaceMesh Box(const Eigen::Vector3d& size, const std::array<int, 3>& cells) {
  return SurfaceOf(MeshBox(size, cells));
}

// Triangles whose centroid lies where `where` says, all three components.
inline Held HeldWhere(const SurfaceMesh& mesh,
                      const std::function<bool(const Eigen::Vector3d&)>& where) {
  Held held;
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
    const bool h = where(Centroid(mesh, i));
    held.push_back({h, h, h});
  }
  return held;
}

inline Held Free(const SurfaceMesh& mesh) {
  return HeldWhere(mesh, [](const Eigen::Vector3d&) { return false; });
}

// Every edge of an icosahedron cut into `parts`: 20 parts^2 triangles, corners on the sphere about
// the origin.
inline SurfaceMesh Sphere(double radius, int parts) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  const std::vector<Eigen::Vector3d> corners{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                             {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                             {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  constexpr std::array<std::array<int, 3>, 20> kFaces{
      {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
       {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
       {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  SurfaceMesh mesh;
  std::map<std::array<long, 3>, int> numbers;
  const auto node = [&](const Eigen::Vector3d& flat) {
    const Eigen::Vector3d p = flat.normalized();
    const auto [found, is_new] = numbers.try_emplace(
        {std::lround(p.x() * 1e9), std::lround(p.y() * 1e9), std::lround(p.z() * 1e9)},
        static_cast<int>(mesh.nodes.size()));
    if (is_new) mesh.nodes.emplace_back(radius * p);
    return found->second;
  };
  for (const auto& [a, b, c] : kFaces) {
    const Eigen::Vector3d& p = corners[static_cast<std::size_t>(a)];
    const Eigen::Vector3d u = (corners[static_cast<std::size_t>(b)] - p) / parts;
    const Eigen::Vector3d v = (corners[static_cast<std::size_t>(c)] - p) / parts;
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; i + j < parts; ++j) {
        const Eigen::Vector3d q = p + i * u + j * v;
        mesh.triangles.push_back({node(q), node(q + u), node(q + v)});
        if (i + j + 1 == parts) continue;
        mesh.triangles.push_back({node(q + u), node(q + u + v), node(q + v)});
      }
    }
  }
  return mesh;
}

// `mesh` with `hole` as a cavity: its triangles follow, turned round.
inline SurfaceMesh WithCavity(SurfaceMesh mesh, const SurfaceMesh& hole) {
  const int first = static_cast<int>(mesh.nodes.size());
  mesh.nodes.insert(mesh.nodes.end(), hole.nodes.begin(), hole.nodes.end());
  for (const auto& [a, b, c] : hole.triangles) {
    mesh.triangles.push_back({first + a, first + c, first + b});
  }
  return mesh;
}

}  // namespace palpate::solid_bodies
