#include "shared/mesh/surface_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/mesh_census.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

const Vector3d& Corner(const SurfaceMesh& surface, int triangle, std::size_t corner) {
  const int node = surface.triangles[static_cast<std::size_t>(triangle)][corner];
  return surface.nodes[static_cast<std::size_t>(node)];
}

struct Edge {
  std::pair<int, int> nodes;
  int triangle;
};

std::vector<Edge> SortedEdges(const SurfaceMesh& surface) {
  std::vector<Edge> edges;
  edges.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& nodes = surface.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) {
      edges.push_back({std::minmax(nodes[i], nodes[(i + 1) % 3]), static_cast<int>(t)});
    }
  }
  std::ranges::sort(edges, {}, &Edge::nodes);
  return edges;
}

// Triangles that share an edge as elements that share a number: PartsOf joins them.
std::vector<SurfacePart> ByEdges(const SurfaceMesh& surface) {
  std::vector<std::array<int, 3>> edges_of(surface.triangles.size());
  std::vector<std::size_t> filled(surface.triangles.size(), 0);
  int number = -1;
  std::pair<int, int> last{-1, -1};
  for (const Edge& edge : SortedEdges(surface)) {
    if (edge.nodes != last) ++number;
    last = edge.nodes;
    const auto t = static_cast<std::size_t>(edge.triangle);
    edges_of[t][filled[t]++] = number;
  }
  int count = 0;
  const std::vector<int> part_of = PartsOf(edges_of, static_cast<std::size_t>(number + 1), &count);
  std::vector<SurfacePart> parts(static_cast<std::size_t>(count));
  for (std::size_t t = 0; t < edges_of.size(); ++t) {
    const int part = part_of[static_cast<std::size_t>(edges_of[t][0])];
    parts[static_cast<std::size_t>(part)].triangles.push_back(static_cast<int>(t));
  }
  return parts;
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

std::vector<SurfacePart> ClosedParts(const SurfaceMesh& surface) {
  std::vector<SurfacePart> parts = ByEdges(surface);
  if (parts.size() > kMostParts) return {};
  for (SurfacePart& part : parts) {
    const Vector3d p = Centroid(surface, part.triangles[0]);
    for (const SurfacePart& other : parts) {
      if (&other != &part && WindingNumber(surface, other.triangles, p) > 0.5) ++part.depth;
    }
  }
  return parts;
}

}  // namespace palpate
