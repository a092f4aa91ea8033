#include "slave/mesh/graded_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include <boost/polygon/point_data.hpp>
#include <boost/polygon/voronoi.hpp>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Point = Eigen::Vector2d;

constexpr double kQuality = 1.35;      // circumradius / shortest edge: angles above 21.7 degrees
constexpr double kEquilateral = 0.66;  // largest circumradius relative to the wanted edge
// Segments shorter than this share of the shortest boundary segment are not refined, so that the
// refinement ends in corners sharper than Ruppert's 60 degrees.
constexpr double kFloor = 0.2;
constexpr double kSliverHeight = 1e-5;  // height relative to the edge of a degenerate triangle

// Centre of the circle through three points.
Point Circumcentre(const Point& a, const Point& b, const Point& c) {
  const Point u = b - a, v = c - a;
  const double d = 2 * (u.x() * v.y() - u.y() * v.x());
  const double uu = u.squaredNorm(), vv = v.squaredNorm();
  return a + Point(v.y() * uu - u.y() * vv, u.x() * vv - v.x() * uu) / d;
}

// Halves segments until each is as short as the field requires.
void SampleBoundary(const SizeField& size, std::vector<Point>& points,
                    std::vector<MeshSegment>& segments) {
  for (std::size_t s = 0; s < segments.size();) {
    const auto [a, b, tag] = segments[s];
    const Point pa = points[Index(a)], pb = points[Index(b)];
    const Point middle = 0.5 * (pa + pb);
    const double wanted = std::min({size.At(middle), 2 * size.At(pa), 2 * size.At(pb)});
    if ((pb - pa).norm() <= wanted) {
      ++s;
      continue;
    }
    points.push_back(middle);
    segments[s].b = static_cast<int>(points.size()) - 1;
    segments.push_back({segments[s].b, b, tag});
  }
}

// Ruppert's refinement. Points are added in rounds, each with one triangulation; triangles whose
// circumcircle contains a new point of the round are skipped. No point is in the circle over a
// segment, except by kFloor, so that segments are edges of triangles.
class Refinement {
 public:
  Refinement(std::vector<Point> points, std::vector<MeshSegment> segments, const SizeField& size,
             int max_points)
      : points_(std::move(points)),
        segments_(std::move(segments)),
        size_(size),
        max_points_(static_cast<std::size_t>(max_points)) {
    floor_ = std::numeric_limits<double>::infinity();
    for (const MeshSegment& s : segments_) floor_ = std::min(floor_, kFloor * Length(s));
  }

  TriangleMesh Run() {
    for (std::size_t p = 0; p < points_.size(); ++p) SplitAround(points_[p]);
    std::vector<std::array<int, 3>> triangles;
    std::size_t before = 0;
    do {
      before = points_.size();
      if (before > max_points_) {
        throw std::runtime_error("mesh: more than " + std::to_string(max_points_) + " points");
      }
      triangles = DelaunayTriangles(points_);
      for (const auto& triangle : triangles) Improve(triangle, before);
    } while (points_.size() > before);
    std::erase_if(triangles, [&](const auto& v) { return !IsInside(v); });
    return Collect(triangles);
  }

 private:
  [[nodiscard]] const Point& At(int point) const { return points_[Index(point)]; }
  [[nodiscard]] double Length(const MeshSegment& s) const { return (At(s.b) - At(s.a)).norm(); }
  [[nodiscard]] bool IsInside(const std::array<int, 3>& v) const {
    const Point &a = At(v[0]), &b = At(v[1]), &c = At(v[2]);
    return Orientation(a, b, c) > kSliverHeight * (b - a).squaredNorm() &&
           Surrounded((a + b + c) / 3);
  }
  // Returns whether an odd number of loops encloses the point.
  [[nodiscard]] bool Surrounded(const Point& p) const {
    bool inside = false;
    for (const MeshSegment& s : segments_) {
      const Point &a = At(s.a), &b = At(s.b);
      if ((a.y() > p.y()) == (b.y() > p.y())) continue;
      inside = inside != ((Orientation(a, b, p) > 0) == (b.y() > a.y()));
    }
    return inside;
  }
  // Halves the segments whose circle contains `p`, if permitted, and then those around their
  // midpoints. Returns whether there is such a segment.
  bool SplitAround(const Point p) {
    bool any = false;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const Point a = At(segments_[s].a), b = At(segments_[s].b);
      if ((a - p).dot(b - p) >= 0) continue;
      any = true;
      if (!((b - a).norm() > floor_)) continue;
      const int middle = static_cast<int>(points_.size());
      points_.emplace_back(0.5 * (a + b));
      segments_.push_back({middle, segments_[s].b, segments_[s].tag});
      segments_[s].b = middle;
      SplitAround(points_.back());
      --s;  // continues with its first half
    }
    return any;
  }
  // `before`: number of points for which the triangle is a Delaunay triangle.
  void Improve(const std::array<int, 3>& v, std::size_t before) {
    const Point &a = At(v[0]), &b = At(v[1]), &c = At(v[2]);
    const Point centre = Circumcentre(a, b, c);
    const double radius = (centre - a).norm();
    const double shortest = std::min({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const bool is_large = radius > kEquilateral * size_.At((a + b + c) / 3);
    if (!is_large && !(radius > kQuality * shortest && shortest > floor_)) return;
    if (!IsInside(v)) return;
    for (std::size_t p = before; p < points_.size(); ++p) {
      if ((points_[p] - centre).norm() < radius) return;
    }
    if (!SplitAround(centre) && Surrounded(centre)) points_.push_back(centre);
  }
  [[nodiscard]] TriangleMesh Collect(const std::vector<std::array<int, 3>>& triangles) const;

  std::vector<Point> points_;
  std::vector<MeshSegment> segments_;
  const SizeField& size_;
  std::size_t max_points_;
  double floor_;
};

TriangleMesh Refinement::Collect(const std::vector<std::array<int, 3>>& triangles) const {
  TriangleMesh mesh;
  std::vector<int> number(points_.size(), -1);
  std::map<std::pair<int, int>, int> triangle_at, tag_of;  // triangle by the ends of an edge
  for (const MeshSegment& s : segments_) tag_of[{s.a, s.b}] = tag_of[{s.b, s.a}] = s.tag;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    auto& corners = mesh.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const int point = triangles[t][i];
      triangle_at[{point, triangles[t][(i + 1) % 3]}] = static_cast<int>(t);
      if (number[Index(point)] < 0) {
        number[Index(point)] = static_cast<int>(mesh.points.size());
        mesh.points.push_back(At(point));
      }
      corners[i] = number[Index(point)];
    }
  }
  for (const auto& v : triangles) {
    auto& behind = mesh.neighbours.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = v[(i + 1) % 3], b = v[(i + 2) % 3];
      const auto segment = tag_of.find({a, b});
      const auto other = triangle_at.find({b, a});
      behind[i] = segment != tag_of.end() || other == triangle_at.end() ? -1 : other->second;
      if (segment == tag_of.end()) continue;
      mesh.boundary.push_back({number[Index(a)], number[Index(b)], segment->second});
    }
  }
  return mesh;
}

// Returns the area inside the segments, positive for any orientation.
double SurroundedArea(const std::vector<Point>& points, const std::vector<MeshSegment>& segments) {
  double twice = 0;
  for (const MeshSegment& s : segments) {
    const Point &a = points[Index(s.a)], &b = points[Index(s.b)];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

}  // namespace

std::vector<std::array<int, 3>> DelaunayTriangles(const std::vector<Point>& points) {
  constexpr double kRaster = 1 << 30;
  Point low = points.front(), high = low;
  for (const Point& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double scale = kRaster / (high - low).maxCoeff();
  std::vector<boost::polygon::point_data<int>> rounded;
  for (const Point& p : points) {
    const Point q = scale * (p - low);
    rounded.emplace_back(static_cast<int>(std::lround(q.x())),
                         static_cast<int>(std::lround(q.y())));
  }
  boost::polygon::voronoi_diagram<double> voronoi;
  boost::polygon::construct_voronoi(rounded.begin(), rounded.end(), &voronoi);
  std::vector<std::array<int, 3>> triangles;
  const auto point = [](const auto* edge) {
    return static_cast<int>(edge->cell()->source_index());
  };
  for (const auto& vertex : voronoi.vertices()) {
    const auto* first = vertex.incident_edge();
    for (const auto* edge = first->rot_next(); edge->rot_next() != first; edge = edge->rot_next()) {
      triangles.push_back({point(first), point(edge), point(edge->rot_next())});
    }
  }
  return triangles;
}

double Orientation(const Point& a, const Point& b, const Point& c) {
  const auto dx = static_cast<long double>(a.x()) - c.x();
  const auto dy = static_cast<long double>(a.y()) - c.y();
  const auto ex = static_cast<long double>(b.x()) - c.x();
  const auto ey = static_cast<long double>(b.y()) - c.y();
  return static_cast<double>(dx * ey - dy * ex);
}

double SizeField::At(const Point& p) const {
  double size = largest;
  for (const Seed& seed : seeds)
    size = std::min(size, seed.size + growth * (p - seed.place).norm());
  return size;
}

TriangleMesh MakeGradedMesh(const std::vector<Point>& points,
                            const std::vector<MeshSegment>& segments, const SizeField& size,
                            int max_points) {
  std::vector<Point> sampled = points;
  std::vector<MeshSegment> pieces = segments;
  SampleBoundary(size, sampled, pieces);
  const TriangleMesh mesh =
      Refinement(std::move(sampled), std::move(pieces), size, max_points).Run();
  const double wanted = SurroundedArea(points, segments);
  if (mesh.triangles.empty() || !(std::abs(Area(mesh) - wanted) <= 1e-9 * wanted)) {
    throw std::runtime_error(
        "mesh: the triangles do not fill the outline; check that it does not intersect itself");
  }
  return mesh;
}

double Area(const TriangleMesh& mesh) {
  double twice = 0;
  for (const auto& v : mesh.triangles) {
    twice +=
        Orientation(mesh.points[Index(v[0])], mesh.points[Index(v[1])], mesh.points[Index(v[2])]);
  }
  return twice / 2;
}

}  // namespace palpate
