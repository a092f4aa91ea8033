#include "shared/mesh/surface_parts.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Geometry>

#include "shared/mesh/mesh_census.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

const Vector3d& Corner(const SurfaceMesh& surface, int triangle, std::size_t corner) {
  const int node = surface.triangles[static_cast<std::size_t>(triangle)][corner];
  return surface.nodes[static_cast<std::size_t>(node)];
}

}  // namespace

double WindingNumber(const SurfaceMesh& surface, const std::vector<int>& triangles,
                     const Vector3d& p) {
  double angle = 0;
  for (const int t : triangles) {
    // Directions only: a solid angle does not depend on lengths.
    const Vector3d a = (Corner(surface, t, 0) - p).normalized();
    const Vector3d b = (Corner(surface, t, 1) - p).normalized();
    const Vector3d c = (Corner(surface, t, 2) - p).normalized();
    angle += 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
  }
  return std::abs(angle) / (4 * std::numbers::pi);
}

double EnclosedVolume(const SurfaceMesh& surface, const std::vector<int>& triangles) {
  if (triangles.empty()) return 0;
  const Vector3d& origin = Corner(surface, triangles[0], 0);
  double volume = 0;
  for (const int t : triangles) {
    const Vector3d a = Corner(surface, t, 0) - origin, b = Corner(surface, t, 1) - origin;
    volume += a.dot(b.cross(Corner(surface, t, 2) - origin)) / 6;
  }
  return volume;
}

std::vector<SurfacePart> PartsOf(const SurfaceMesh& surface) {
  int count = 0;
  const std::vector<int> part_of = PartsOf(surface.triangles, surface.nodes.size(), &count);
  std::vector<SurfacePart> parts(static_cast<std::size_t>(count));
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const int part = part_of[static_cast<std::size_t>(surface.triangles[t][0])];
    parts[static_cast<std::size_t>(part)].triangles.push_back(static_cast<int>(t));
  }
  for (SurfacePart& part : parts) {
    const Vector3d& p = Corner(surface, part.triangles[0], 0);
    for (const SurfacePart& other : parts) {
      if (&other != &part && WindingNumber(surface, other.triangles, p) > 0.5) ++part.depth;
    }
  }
  return parts;
}

}  // namespace palpate
