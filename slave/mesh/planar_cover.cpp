#include "slave/mesh/planar_cover.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "slave/mesh/graded_mesh.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kSpace = 0.7;  // smallest distance from the boundary relative to the spacing [-]
// Area of a degenerate triangle relative to the body's bounding box [-].
constexpr double kSliverArea = 1e-9;

Outline OutlineOf(const BoundaryMesh& mesh) {
  Outline outline;
  for (std::size_t loop = 0; loop + 1 < mesh.loop_begin.size(); ++loop) {
    auto& points = loop == 0 ? outline.outer : outline.holes.emplace_back();
    for (int i = mesh.loop_begin[loop]; i < mesh.loop_begin[loop + 1]; ++i) {
      points.push_back(mesh.elements[Index(i)].a);
    }
  }
  return outline;
}

double AreaOf(const Outline& outline) {
  double area = std::abs(SignedArea(outline.outer));
  for (const auto& hole : outline.holes) area -= std::abs(SignedArea(hole));
  return area;
}

double Clearance(const BoundaryElement& e, const Vector2d& p) {
  const Vector2d along = e.b - e.a;
  const double share = std::clamp((p - e.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - e.a - share * along).norm();
}

// Returns rows of places inside, with every other row shifted by half the spacing.
std::vector<Vector2d> PlacesInside(const BoundaryMesh& mesh, const Outline& outline,
                                   const Eigen::AlignedBox2d& box, double spacing) {
  std::vector<Vector2d> places;
  const double row_height = std::sqrt(0.75) * spacing;
  bool is_moved = false;
  for (double y = box.min().y() + 0.5 * row_height; y < box.max().y(); y += row_height) {
    is_moved = !is_moved;
    for (double x = box.min().x() + (is_moved ? 0.5 : 1) * spacing; x < box.max().x();
         x += spacing) {
      const Vector2d p(x, y);
      const bool is_clear = std::ranges::all_of(mesh.elements, [&](const BoundaryElement& e) {
        return Clearance(e, p) >= std::max(kSpace * spacing, e.length());
      });
      if (is_clear && Contains(outline, p)) places.push_back(p);
    }
  }
  return places;
}

}  // namespace

PlanarCover CoverOf(const BoundaryMesh& mesh, int places) {
  Eigen::AlignedBox2d box;
  std::vector<Vector2d> points;
  for (const BoundaryElement& e : mesh.elements) {
    box.extend(e.a);
    points.push_back(e.a);
  }
  const Outline outline = OutlineOf(mesh);
  const double spacing = std::sqrt(AreaOf(outline) / (std::sqrt(0.75) * places));
  PlanarCover cover;
  cover.inside = PlacesInside(mesh, outline, box, spacing);
  points.insert(points.end(), cover.inside.begin(), cover.inside.end());
  for (const auto& triangle : DelaunayTriangles(points)) {
    const auto& [a, b, c] = triangle;
    const Vector2d &p_a = points[Index(a)], &p_b = points[Index(b)], &p_c = points[Index(c)];
    const bool is_flat = Orientation(p_a, p_b, p_c) < kSliverArea * box.volume();
    if (!is_flat && Contains(outline, (p_a + p_b + p_c) / 3)) cover.triangles.push_back(triangle);
  }
  return cover;
}

}  // namespace palpate
