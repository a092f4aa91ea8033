// Slabs that are fine under a tool, of cells that do not lock.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mesh/index.h"
#include "tests/support/fixed_nodes.h"

namespace palpate::solids {

// From zero: `fine` in steps of about `side`, then steps that grow by `growth`, up to `end`.
inline std::vector<double> GradedSteps(double fine, double side, double growth, double end) {
  std::vector<double> at{0};
  const double count = std::round(fine / side);
  for (int i = 1; i <= static_cast<int>(count); ++i) at.push_back(fine * i / count);
  const auto grown = [&](int steps) { return (std::pow(growth, steps) - 1) / (growth - 1); };
  int steps = 0;
  while (growth * side * grown(steps) < end - fine) ++steps;
  for (int i = 1; i <= steps; ++i) at.push_back(fine + (end - fine) * grown(i) / grown(steps));
  return at;
}
// Returns `steps`, which begin at 0, and their negatives.
inline std::vector<double> Mirrored(const std::vector<double>& steps) {
  std::vector<double> all;
  for (auto it = steps.rbegin(); it != steps.rend(); ++it) all.push_back(-*it);
  all.insert(all.end(), steps.begin() + 1, steps.end());
  return all;
}

inline void AddTet(std::array<int, 4> tet, SolidMesh* mesh) {
  mesh->tets.push_back(tet);
  if (SignedVolume(*mesh, static_cast<int>(mesh->tets.size()) - 1) < 0) {
    std::swap(mesh->tets.back()[2], mesh->tets.back()[3]);
  }
}

// Divides every cell of a grid into 24 tetrahedra at its centre and the centres of its faces.
// Unlike MeshBox's cells, such a cell has more unknowns than incompressibility constraints.
inline SolidMesh CrossedBox(const std::array<std::vector<double>, 3>& grid) {
  SolidMesh mesh;
  std::map<std::array<int, 3>, int> number;  // number of each node, by twice its grid position
  const auto node = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = number.try_emplace(at, static_cast<int>(mesh.nodes.size()));
    if (is_new) {
      Eigen::Vector3d& p = mesh.nodes.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) {
        const std::vector<double>& v = grid[c];
        p[static_cast<int>(c)] = 0.5 * (v[Index(at[c] / 2)] + v[Index((at[c] + 1) / 2)]);
      }
    }
    return found->second;
  };
  const auto add_face = [&](const std::array<int, 3>& middle, std::size_t axis, int side) {
    constexpr std::array<std::array<int, 2>, 4> kAround{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
    std::array<int, 3> face = middle;
    face[axis] += side;
    for (std::size_t v = 0; v < 4; ++v) {
      std::array<int, 3> from = face, to = face;
      for (std::size_t c = 0; c < 2; ++c) {
        from[(axis + 1 + c) % 3] += kAround[v][c];
        to[(axis + 1 + c) % 3] += kAround[(v + 1) % 4][c];
      }
      AddTet({node(middle), node(face), node(from), node(to)}, &mesh);
    }
  };
  for (int i = 1; i < static_cast<int>(grid[0].size()); ++i) {
    for (int j = 1; j < static_cast<int>(grid[1].size()); ++j) {
      for (int k = 1; k < static_cast<int>(grid[2].size()); ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (const int side : {-1, 1}) add_face({2 * i - 1, 2 * j - 1, 2 * k - 1}, axis, side);
        }
      }
    }
  }
  return mesh;
}

// Adds on every triangle of `skin` a prism of three tetrahedra up to the triangle scaled by
// `growth`. Each prism is divided from its lowest node up, so that neighbours share their
// diagonals. `skin` becomes the scaled triangles.
inline void GrowShell(double growth, std::vector<std::array<int, 3>>* skin, SolidMesh* mesh) {
  std::vector<int> image(mesh->nodes.size(), -1);
  for (std::array<int, 3>& triangle : *skin) {
    std::ranges::sort(triangle);
    std::array<int, 3> up{};
    for (std::size_t v = 0; v < 3; ++v) {
      int& known = image[Index(triangle[v])];
      if (known < 0) {
        known = static_cast<int>(mesh->nodes.size());
        mesh->nodes.push_back(growth * mesh->nodes[Index(triangle[v])]);
      }
      up[v] = known;
    }
    AddTet({triangle[0], triangle[1], triangle[2], up[2]}, mesh);
    AddTet({triangle[0], triangle[1], up[1], up[2]}, mesh);
    AddTet({triangle[0], up[0], up[1], up[2]}, mesh);
    triangle = up;
  }
}

// The top is the plane z = 0 with the origin at its centre. The core is 2 `core` wide and `core`
// high with cells of `core` / `cells`. It is surrounded by shells whose cells grow with the
// distance, up to `extent`.
inline SolidMesh GradedSlab(double core, int cells, double extent) {
  const std::vector<double> half = GradedSteps(core, core / cells, 2, core);
  std::vector<double> down = Mirrored(half);
  down.resize(half.size());
  SolidMesh mesh = CrossedBox({Mirrored(half), Mirrored(half), down});
  std::vector<std::array<int, 3>> skin;
  for (const auto& triangle : SurfaceOf(mesh).triangles) {
    const bool top = std::ranges::all_of(
        triangle, [&](int n) { return mesh.nodes[Index(n)].z() > -1e-9 * core; });
    if (!top) skin.push_back(triangle);
  }
  const double shells = std::ceil(std::log(extent / core) * cells);
  for (int s = 0; s < static_cast<int>(shells); ++s) {
    GrowShell(std::pow(extent / core, 1 / shells), &skin, &mesh);
  }
  return mesh;
}

}  // namespace palpate::solids
