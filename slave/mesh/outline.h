// The boundary of a planar body as polygons, and its straight boundary elements.
// Frame O [m]. The outer loop runs counter-clockwise, holes clockwise, so that the body lies to the
// left of every element and the outward normal is the tangent turned by -90 degrees.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace palpate {

// z component of the cross product: positive if `v` lies counter-clockwise of `u`.
inline double Cross(const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
  return u.x() * v.y() - u.y() * v.x();
}

// Closed polygons: the last point joins the first.
struct Outline {
  std::vector<Eigen::Vector2d> outer;               // counter-clockwise, >= 3 points
  std::vector<std::vector<Eigen::Vector2d>> holes;  // any direction; meshing turns them clockwise
};

// BoundaryElement is a straight element from `a` to `b`.
struct BoundaryElement {
  Eigen::Vector2d a, b;
  [[nodiscard]] double length() const { return (b - a).norm(); }
  [[nodiscard]] Eigen::Vector2d midpoint() const { return 0.5 * (a + b); }
  [[nodiscard]] Eigen::Vector2d normal() const {
    const Eigen::Vector2d t = (b - a).normalized();
    return {t.y(), -t.x()};
  }
};

// Elements in order along each loop: loop k owns [loop_begin[k], loop_begin[k + 1]).
struct BoundaryMesh {
  std::vector<BoundaryElement> elements;
  std::vector<int> loop_begin;  // loops + 1 entries, the last one is elements.size()
  double length_unit = 1;  // bem2d scales lengths by it [m]: the larger side, of a disc the radius

  [[nodiscard]] int size() const { return static_cast<int>(elements.size()); }
  // The element after / before `i` along its own loop.
  [[nodiscard]] int Next(int i) const;
  [[nodiscard]] int Previous(int i) const;
};

// Rectangle from (0, 0), counter-clockwise from the lower left corner. Each side is divided into
// elements of equal length, `count` in total, in proportion to the sides' lengths, at least one
// each. Throws std::invalid_argument: sizes not positive and finite, count < 4.
BoundaryMesh MeshRectangle(double width, double height, int count);
// Inscribed regular polygon, first vertex at -pi / count, element 0 centred at angle 0. Throws:
// count < 3.
BoundaryMesh MeshDisc(double radius, int count);
// Each edge gets at least one element, the others in proportion to length, `count` in total (more
// if there are more edges). Throws std::invalid_argument: fewer than three points, repeated points,
// no area, crossing edges, hole outside.
BoundaryMesh MeshPolygon(const Outline& outline, int count);

// Signed area [m^2], positive counter-clockwise.
double SignedArea(const std::vector<Eigen::Vector2d>& loop);
// Centre of the enclosed area [m]. The loop has an area other than zero.
Eigen::Vector2d Centroid(const std::vector<Eigen::Vector2d>& loop);
// `p` lies inside the outer loop and outside the holes.
bool Contains(const Outline& outline, const Eigen::Vector2d& p);

// Validation of outlines.

// Throws std::invalid_argument with the position of the error: a loop of fewer than three points, a
// coordinate that is not finite, repeated points, no area (below 1e-12 of the bounding square),
// edges that cross, touch or fold back, a hole outside the outer loop or inside another hole. The
// loops may have any orientation. O(points^2).
void CheckOutline(const Outline& outline);

}  // namespace palpate
