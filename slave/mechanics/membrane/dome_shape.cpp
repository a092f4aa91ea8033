#include "slave/mechanics/membrane/dome_shape.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "shared/text/text.h"

namespace palpate {
namespace {

// Nodes at `place` of (radius share, angle), ring by ring about the centre, the outermost held;
// triangles counter-clockwise.
MembraneShape MakeRings(int rings, const std::function<Eigen::Vector3d(double, double)>& place) {
  if (rings < 1 || rings > 1000) RefuseValue("rings", rings, "1 to 1000");
  MembraneShape made;
  auto& [nodes, triangles] = made.surface;
  nodes.push_back(place(0, 0));
  const auto first = [](int ring) { return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1); };
  for (int ring = 1; ring <= rings; ++ring) {
    const int count = 6 * ring;
    const int inner_count = std::max(1, count - 6);
    for (int k = 0; k < count; ++k) {
      nodes.push_back(place(static_cast<double>(ring) / rings, 2 * std::numbers::pi * k / count));
      // Sextant and step in it: the ring inside has one step fewer.
      const int sextant = k / ring;
      const int step = k % ring;
      const int outer = first(ring) + k;
      const int outer_next = first(ring) + (k + 1) % count;
      const int inner = first(ring - 1) + (sextant * (ring - 1) + step) % inner_count;
      triangles.push_back({outer, outer_next, inner});
      if (step < ring - 1) {
        const int inner_next = first(ring - 1) + (sextant * (ring - 1) + step + 1) % inner_count;
        triangles.push_back({inner, outer_next, inner_next});
      }
      if (ring == rings) made.held.push_back(outer);
    }
  }
  return made;
}

}  // namespace

double DistanceOutside(const Ellipsoid& ellipsoid, const Eigen::Vector3d& p) {
  const Eigen::Matrix3d inverse = ellipsoid.semi_axes.inverse();
  const Eigen::Vector3d on_sphere = inverse * (p - ellipsoid.centre);
  const double radius = on_sphere.norm();
  return (radius - 1) * radius / (inverse * on_sphere).norm();
}

MembraneShape MeshFlatMembrane(double radius, int rings) {
  RequirePositive("radius", radius);
  return MakeRings(rings, [&](double share, double angle) {
    const double r = radius * share;
    return Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0);
  });
}

MembraneShape MeshDomedMembrane(const Ellipsoid& ellipsoid, const Eigen::Vector3d& axis, double rim,
                                int rings) {
  const Eigen::Vector3d e1 = axis.unitOrthogonal();
  const Eigen::Vector3d e2 = axis.cross(e1);
  const Eigen::Matrix3d inverse = ellipsoid.semi_axes.inverse();
  // The point of the ellipsoid that lies under this angle from the axis.
  const auto point = [&](double polar, double angle) -> Eigen::Vector3d {
    const Eigen::Vector3d ray = std::cos(polar) * axis + std::sin(polar) * std::cos(angle) * e1 +
                                std::sin(polar) * std::sin(angle) * e2;
    return ellipsoid.centre + ray / (inverse * ray).norm();
  };
  const auto above = [&](const Eigen::Vector3d& p) { return p.dot(axis) - rim; };
  if (!(above(point(0, 0)) > 0 && above(point(std::numbers::pi, 0)) < 0)) {
    RefuseValue("rim", rim, "a plane that cuts the ellipsoid along the axis");
  }
  return MakeRings(rings, [&](double share, double angle) {
    double low = 0;
    double high = std::numbers::pi;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      (above(point(middle, angle)) > 0 ? low : high) = middle;
    }
    return point(share * low, angle);
  });
}

}  // namespace palpate
