#include "slave/mechanics/mesher/hole_points.h"

#include <algorithm>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "shared/mesh/surface_parts.h"
#include "shared/mesh/surface_patch.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Distance along the unit `direction` to triangle a b c; nullopt: the ray misses it. Source:
// Moeller and Trumbore, J. Graphics Tools 2 (1997) 21-28.
std::optional<double> Hit(const Vector3d& origin, const Vector3d& direction, const Vector3d& a,
                          const Vector3d& b, const Vector3d& c) {
  const Vector3d across = direction.cross(c - a);
  const double determinant = (b - a).dot(across);
  if (determinant == 0) return std::nullopt;
  const Vector3d from = origin - a;
  const double u = from.dot(across) / determinant;
  const Vector3d turned = from.cross(b - a);
  const double v = direction.dot(turned) / determinant;
  if (u < 0 || v < 0 || u + v > 1) return std::nullopt;
  const double distance = (c - a).dot(turned) / determinant;
  return distance > 0 ? std::optional(distance) : std::nullopt;
}

Vector3d PointBefore(const SurfaceMesh& surface, int triangle) {
  const Vector3d origin = Centroid(surface, triangle), direction = Normal(surface, triangle);
  double nearest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (t == triangle) continue;
    const auto& [a, b, c] = surface.triangles[static_cast<std::size_t>(t)];
    const auto p = [&](int i) -> const Vector3d& {
      return surface.nodes[static_cast<std::size_t>(i)];
    };
    if (const auto distance = Hit(origin, direction, p(a), p(b), p(c))) {
      nearest = std::min(nearest, *distance);
    }
  }
  return origin + 0.5 * nearest * direction;
}

}  // namespace

std::vector<Vector3d> HolePoints(const SurfaceMesh& surface) {
  std::vector<Vector3d> points;
  for (const SurfacePart& part : ClosedParts(surface)) {
    if (part.depth % 2 == 0) continue;
    const int largest = *std::ranges::max_element(
        part.triangles, {}, [&](int triangle) { return Area(surface, triangle); });
    points.push_back(PointBefore(surface, largest));
  }
  return points;
}

}  // namespace palpate
