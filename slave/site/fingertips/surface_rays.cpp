#include "slave/site/fingertips/surface_rays.h"

#include <array>
#include <cstddef>

#include <Eigen/Geometry>

namespace palpate::site {
namespace {

using Eigen::Vector3d;

// Moeller and Trumbore's test (1997).
std::optional<double> Crossing(const std::array<Vector3d, 3>& abc, const Vector3d& p,
                               const Vector3d& d) {
  const Vector3d ab = abc[1] - abc[0], ac = abc[2] - abc[0];
  const Vector3d across = d.cross(ac);
  const double determinant = ab.dot(across);
  if (determinant == 0) return std::nullopt;
  const Vector3d ap = p - abc[0];
  const double u = ap.dot(across) / determinant;
  const Vector3d turned = ap.cross(ab);
  const double v = d.dot(turned) / determinant;
  const double t = ac.dot(turned) / determinant;
  if (!(u >= 0 && v >= 0 && u + v <= 1 && t > 0)) return std::nullopt;
  return t;
}

std::array<Vector3d, 3> CornersOf(const SurfaceMesh& surface, const std::array<int, 3>& triangle) {
  std::array<Vector3d, 3> abc;
  for (std::size_t i = 0; i < 3; ++i) {
    abc[i] = surface.nodes[static_cast<std::size_t>(triangle[i])];
  }
  return abc;
}

}  // namespace

std::optional<RayHit> FirstHit(const SurfaceMesh& surface, const Vector3d& p_O,
                               const Vector3d& direction_O) {
  std::optional<RayHit> first;
  for (const auto& triangle : surface.triangles) {
    const auto abc = CornersOf(surface, triangle);
    const auto t = Crossing(abc, p_O, direction_O);
    if (!t || (first && *t >= first->distance)) continue;
    first = {*t, (abc[1] - abc[0]).cross(abc[2] - abc[0]).normalized()};
  }
  return first;
}

bool IsInside(const SurfaceMesh& surface, const Vector3d& p_O) {
  const Vector3d d = Vector3d(0.5377, 0.7139, 0.4483).normalized();  // along no edge of a box
  bool inside = false;
  for (const auto& triangle : surface.triangles) {
    if (Crossing(CornersOf(surface, triangle), p_O, d)) inside = !inside;
  }
  return inside;
}

}  // namespace palpate::site
