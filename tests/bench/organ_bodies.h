// Bodies and tools of the organ benchmark: six shapes, each a mapped lattice of cells with
// supports, and places on their faces where tools press before they are dragged.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate::organs {

using Eigen::Vector3d;

struct Body {
  std::string name;
  SolidMesh mesh;
  HeldNodes held;
  double cell = 0;  // mean edge of the lattice [m]
};

// `shape` maps the unit cube to the body [m]; `held`: whether a point of the cube is fixed.
inline Body Make(const std::string& name, const Vector3d& extent, int tets,
                 const std::function<Vector3d(const Vector3d&)>& shape,
                 const std::function<bool(const Vector3d&)>& held) {
  Body body{name, {}, {}, std::cbrt(6 * extent.prod() / tets)};
  const Eigen::Array3i cells = (extent / body.cell).array().round().max(2).cast<int>();
  body.mesh = MeshBox({1, 1, 1}, {cells[0], cells[1], cells[2]});
  for (Vector3d& p : body.mesh.nodes) {
    const bool h = held(p);
    body.held.push_back({h, h, h});
    p = shape(p);
  }
  return body;
}

inline Vector3d Liver(const Vector3d& at) {
  const double u = 2 * at[0] - 1, v = 2 * at[1] - 1, w = at[2];
  const double x = u * std::sqrt(1 - v * v / 4), y = v * std::sqrt(1 - u * u / 4);
  const double s = 1 - w * w / 10, height = 0.062 * (1 - (x * x + y * y) / 5) * (1 - x / 4);
  return {0.08 * s * x, 0.052 * s * (y + x * x / 10 - 0.05), w * height};
}

// 0: slab, 1: liver, 2: cube, 3: wedge, 4: dome, 5: bent bar held at both ends.
inline Body MakeBody(int number, int tets) {
  const auto bottom = [](const Vector3d& p) { return p[2] == 0; };
  const auto ends = [](const Vector3d& p) { return p[0] == 0 || p[0] == 1; };
  const auto box = [](const Vector3d& extent) {
    return [extent](const Vector3d& p) -> Vector3d { return p.cwiseProduct(extent); };
  };
  switch (number) {
    case 0:
      return Make("slab", {0.12, 0.12, 0.04}, tets, box({0.12, 0.12, 0.04}), bottom);
    case 1:
      return Make("liver", {0.16, 0.104, 0.062}, tets, Liver, bottom);
    case 2:
      return Make("cube", {0.08, 0.08, 0.08}, tets, box({0.08, 0.08, 0.08}), bottom);
    case 3:
      return Make(
          "wedge", {0.12, 0.08, 0.06}, tets,
          [](const Vector3d& p) -> Vector3d {
            return {0.12 * p[0], 0.08 * p[1], p[2] * (0.07 - 0.03 * p[0])};
          },
          bottom);
    case 4:
      return Make(
          "dome", {0.1, 0.1, 0.06}, tets,
          [](const Vector3d& p) -> Vector3d {
            const double x = 2 * p[0] - 1, y = 2 * p[1] - 1;
            return {0.05 * x, 0.05 * y, p[2] * (0.07 - 0.015 * (x * x + y * y))};
          },
          bottom);
    default:
      return Make(
          "bar", {0.16, 0.06, 0.05}, tets,
          [](const Vector3d& p) -> Vector3d {
            const double x = 2 * p[0] - 1;
            return {0.08 * x, 0.06 * p[1], 0.05 * p[2] + 0.015 * (1 - x * x)};
          },
          ends);
  }
}

inline constexpr int kBodies = 6;

struct Place {
  Vector3d p_O, normal, along;  // on the surface, outward, across that
  std::string face;
};

// Returns the first `count` of eight separate places: five on the top and three on the sides.
inline std::vector<Place> PlacesOn(const Body& body, int count) {
  const SurfaceMesh surface = SurfaceOf(body.mesh);
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : body.mesh.nodes) box.extend(p);
  // Places as fractions of the box, and the direction in which to search for the surface.
  constexpr double kAt[][4] = {{.30, .45, 1, 2}, {.2, 0, .55, 1},  {.75, .7, 1, 2},
                               {.7, 0, .6, 1},   {.72, .25, 1, 2}, {.25, .8, 1, 2},
                               {.45, 1, .55, 1}, {.5, .42, 1, 2}};
  std::vector<Place> places;
  for (int k = 0; k < count; ++k) {
    const auto& at = kAt[k];
    const Vector3d share(at[0], at[1], at[2]);
    const Vector3d p = box.min() + share.cwiseProduct(box.sizes());
    const int axis = static_cast<int>(at[3]);
    const Vector3d out = (share[axis] > 0.5 ? 1 : -1) * Vector3d::Unit(axis);
    int best = -1;
    double least = 1e300;
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
      const auto& corners = surface.triangles[static_cast<std::size_t>(t)];
      const bool is_held = std::ranges::any_of(
          corners, [&](int node) { return body.held[static_cast<std::size_t>(node)][0]; });
      if (is_held || Normal(surface, t).dot(out) < 0.6) continue;
      Vector3d from = Centroid(surface, t) - p;
      from[axis] *= 0.1;
      if (from.norm() < least) least = from.norm(), best = t;
    }
    const Vector3d n = Normal(surface, best);
    const Vector3d across = n.cross(std::abs(n[0]) < 0.6 ? Vector3d::UnitX() : Vector3d::UnitY());
    places.push_back({Centroid(surface, best), n, across.normalized(), axis == 2 ? "top" : "side"});
  }
  return places;
}

}  // namespace palpate::organs
