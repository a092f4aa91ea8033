#include "shared/patch/patch_place.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kEquallyNear = 1e-9;  // tolerance relative to the squared distance
constexpr double kOnEdge = 1e-9;       // barycentric weight of an edge

Vector3d Vertex(const SurfacePatch& patch, int cell, int corner) {
  return patch.vertices[static_cast<std::size_t>(VertexOf(patch, cell, corner))].cast<double>();
}

// Returns the weights of the point on segment a, b that is nearest to p.
Vector3d OnLine(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const double length2 = (b - a).squaredNorm();
  const double s = length2 > 0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
  return {1 - s, s, 0};
}

// Returns the nearest point of a triangle: inside it, else on the nearest of its edges.
Vector3d OnTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p) {
  const Vector3d n = (b - a).cross(c - a);
  const double area2 = n.squaredNorm();
  if (area2 > 0) {
    const double u = (c - b).cross(p - b).dot(n) / area2;
    const double v = (a - c).cross(p - c).dot(n) / area2;
    if (u >= 0 && v >= 0 && u + v <= 1) return {u, v, 1 - u - v};
  }
  const Vector3d ab = OnLine(a, b, p), bc = OnLine(b, c, p), ca = OnLine(c, a, p);
  const std::array<Vector3d, 3> edges{Vector3d(ab[0], ab[1], 0), Vector3d(0, bc[0], bc[1]),
                                      Vector3d(ca[1], 0, ca[0])};
  const auto away = [&](const Vector3d& w) { return (w[0] * a + w[1] * b + w[2] * c - p).norm(); };
  return *std::ranges::min_element(edges, {}, away);
}

PatchPlace InCell(const SurfacePatch& patch, int cell, const Vector3d& p) {
  const Vector3d a = Vertex(patch, cell, 0), b = Vertex(patch, cell, 1);
  PatchPlace place;
  place.cell = cell;
  if (patch.vertices_per_cell == 2) {
    place.weights = OnLine(a, b, p);
    place.p = place.weights[0] * a + place.weights[1] * b;
    place.normal = Vector3d(b.y() - a.y(), a.x() - b.x(), 0).stableNormalized();
    return place;
  }
  const Vector3d c = Vertex(patch, cell, 2);
  place.weights = OnTriangle(a, b, c, p);
  place.p = place.weights[0] * a + place.weights[1] * b + place.weights[2] * c;
  place.normal = (b - a).cross(c - a).stableNormalized();
  return place;
}

PatchPlace OnPlane(const SurfacePatch& patch, const Vector3d& p) {
  PatchPlace place;
  place.normal = patch.normal;
  place.height = patch.normal.dot(p - patch.vertices[0].cast<double>());
  place.p = p - place.height * patch.normal;
  return place;
}

// The rim is end `k` of a line, or the edge opposite to corner `k` of a triangle.
bool IsAtRim(const SurfacePatch& patch, const PatchPlace& place) {
  const unsigned rim = patch.rim[static_cast<std::size_t>(place.cell)];
  for (int k = 0; k < patch.vertices_per_cell; ++k) {
    const double off = patch.vertices_per_cell == 2 ? 1 - place.weights[k] : place.weights[k];
    if ((rim >> static_cast<unsigned>(k) & 1U) != 0 && off < kOnEdge) return true;
  }
  return false;
}

bool Has(const SurfacePatch& patch, int cell, int vertex) {
  for (int k = 0; k < patch.vertices_per_cell; ++k) {
    if (VertexOf(patch, cell, k) == vertex) return true;
  }
  return false;
}

// Returns whether no other cell has all corners of this one except `corner`: the edge of a triangle
// or the end of a line is free.
bool IsRim(const SurfacePatch& patch, int cell, int corner) {
  for (int other = 0; other < patch.cell_count; ++other) {
    if (other == cell) continue;
    bool shared = true;
    for (int k = 0; k < patch.vertices_per_cell; ++k) {
      const bool counts = patch.vertices_per_cell == 2 ? k == corner : k != corner;
      if (counts) shared = shared && Has(patch, other, VertexOf(patch, cell, k));
    }
    if (shared) return false;
  }
  return true;
}

}  // namespace

PatchPlace NearestPlace(const SurfacePatch& patch, const Vector3d& p) noexcept {
  if (patch.vertices_per_cell == 1) return OnPlane(patch, p);
  PatchPlace nearest;
  double least = std::numeric_limits<double>::infinity(), max_height = 0;
  for (int cell = 0; cell < patch.cell_count; ++cell) {
    const PatchPlace place = InCell(patch, cell, p);
    const double away2 = (p - place.p).squaredNorm();
    const double height = std::abs(place.normal.dot(p - place.p));
    const bool alike = std::abs(away2 - least) <= kEquallyNear * away2;
    if (alike ? height <= max_height : away2 >= least) continue;
    nearest = place;
    least = away2;
    max_height = height;
  }
  if (nearest.cell < 0) return nearest;
  const double side = nearest.normal.dot(p - nearest.p) < 0 ? -1 : 1;
  nearest.height = side * std::sqrt(least);
  nearest.at_rim = IsAtRim(patch, nearest);
  return nearest;
}

void MarkRim(SurfacePatch* patch) noexcept {
  for (int cell = 0; cell < patch->cell_count; ++cell) {
    unsigned rim = 0;
    for (int k = 0; k < patch->vertices_per_cell; ++k) {
      if (IsRim(*patch, cell, k)) rim |= 1U << static_cast<unsigned>(k);
    }
    patch->rim[static_cast<std::size_t>(cell)] = static_cast<std::uint8_t>(rim);
  }
}

}  // namespace palpate
