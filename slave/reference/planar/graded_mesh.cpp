#include "slave/reference/planar/graded_mesh.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/geometry/index.h"

namespace palpate::site {
namespace {

using Point = Eigen::Vector2d;

constexpr double kQuality = 1.35;      // circumradius / shortest edge: angles above 21.7 degrees
constexpr double kEquilateral = 0.66;  // circumradius / wanted edge before a triangle is too large
// Nothing shorter than this part of the shortest boundary piece is halved or judged: ends the
// refinement in corners sharper than Ruppert's 60 degrees.
constexpr double kFloor = 0.2;

// Halves segments until each is as short as the field asks.
void SampleBoundary(const SizeField& size, std::vector<Point>& points,
                    std::vector<Segment>& segments) {
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

class Refinement {
 public:
  Refinement(Delaunay& mesh, const SizeField& size, int max_points)
      : mesh_(mesh), size_(size), max_points_(static_cast<std::size_t>(max_points)) {
    floor_ = std::numeric_limits<double>::infinity();
    for (const Segment& s : mesh.segments()) {
      floor_ = std::min(floor_, kFloor * (At(s.b) - At(s.a)).norm());
    }
  }

  void Run() {
    for (int t = 0; t < static_cast<int>(mesh_.triangles().size()); ++t) CheckTriangle(t);
    while (!bad_.empty() || !encroached_.empty()) {
      if (mesh_.points().size() > max_points_) {
        throw std::runtime_error("mesh: more than " + std::to_string(max_points_) + " points");
      }
      if (!encroached_.empty()) {
        const auto [s, end] = encroached_.back();
        encroached_.pop_back();
        // Another end: halved since, and its halves were looked at then.
        if (mesh_.segments()[Index(s)].b == end && MaySplit(s)) Split(s);
      } else {
        const auto [t, generation] = bad_.front();
        bad_.pop_front();
        if (Tri(t).alive && Tri(t).generation == generation) Improve(t);
      }
    }
  }

 private:
  [[nodiscard]] const Point& At(int point) const { return mesh_.points()[Index(point)]; }
  [[nodiscard]] const Delaunay::Triangle& Tri(int t) const { return mesh_.triangles()[Index(t)]; }

  [[nodiscard]] bool IsBad(int t) const {
    const auto& v = Tri(t).vertex;
    const Point &a = At(v[0]), &b = At(v[1]), &c = At(v[2]);
    const double radius = (Circumcentre(a, b, c) - a).norm();
    const double shortest = std::min({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const double wanted = size_.At((a + b + c) / 3);
    if (radius > kEquilateral * wanted) return true;
    return radius > kQuality * shortest && shortest > floor_;
  }
  // `apex` lies in the circle over a and b.
  [[nodiscard]] static bool IsObtuse(const Point& apex, const Point& a, const Point& b) {
    return (a - apex).dot(b - apex) < 0;
  }
  [[nodiscard]] bool MaySplit(int s) const {
    const Segment& segment = mesh_.segments()[Index(s)];
    return (At(segment.b) - At(segment.a)).norm() > floor_;
  }
  void CheckTriangle(int t) {
    const auto& tri = Tri(t);
    if (!tri.alive || !tri.inside) return;
    for (std::size_t i = 0; i < 3; ++i) {
      if (tri.segment[i] == Delaunay::kNone) continue;
      if (IsObtuse(At(tri.vertex[i]), At(tri.vertex[(i + 1) % 3]), At(tri.vertex[(i + 2) % 3]))) {
        const int s = tri.segment[i];
        encroached_.emplace_back(s, mesh_.segments()[Index(s)].b);
      }
    }
    if (IsBad(t)) bad_.emplace_back(t, tri.generation);
  }
  void CheckNewTriangles() {
    for (const int t : mesh_.created()) CheckTriangle(t);
  }
  void Split(int s) {
    mesh_.SplitSegment(s);
    CheckNewTriangles();
  }
  void Improve(int t) {
    const auto& v = Tri(t).vertex;
    const unsigned generation = Tri(t).generation;
    const bool reachable = mesh_.Prepare(Circumcentre(At(v[0]), At(v[1]), At(v[2])), t);
    std::vector<int> in_the_way = mesh_.encroached();
    if (!reachable) in_the_way.push_back(mesh_.blocking_segment());
    if (in_the_way.empty()) {
      mesh_.Commit();
      CheckNewTriangles();
      return;
    }
    bool split = false;
    for (const int s : in_the_way) {
      if (!MaySplit(s)) continue;
      Split(s);
      split = true;
    }
    if (split) bad_.emplace_back(t, generation);
  }

  Delaunay& mesh_;
  const SizeField& size_;
  std::size_t max_points_;
  double floor_;
  std::deque<std::pair<int, unsigned>> bad_;     // triangle and its generation when it was seen
  std::vector<std::pair<int, int>> encroached_;  // segment and its end when it was seen
};

TriangleMesh Collect(const Delaunay& from) {
  TriangleMesh mesh;
  std::vector<int> point_of(from.points().size(), -1), triangle_of(from.triangles().size(), -1);
  for (std::size_t t = 0; t < from.triangles().size(); ++t) {
    const auto& tri = from.triangles()[t];
    if (!tri.alive || !tri.inside) continue;
    triangle_of[t] = static_cast<int>(mesh.triangles.size());
    std::array<int, 3> v{};
    for (std::size_t i = 0; i < 3; ++i) {
      int& number = point_of[Index(tri.vertex[i])];
      if (number < 0) {
        number = static_cast<int>(mesh.points.size());
        mesh.points.push_back(from.points()[Index(tri.vertex[i])]);
      }
      v[i] = number;
    }
    mesh.triangles.push_back(v);
  }
  for (std::size_t t = 0; t < from.triangles().size(); ++t) {
    if (triangle_of[t] < 0) continue;
    const auto& tri = from.triangles()[t];
    auto& behind = mesh.neighbours.emplace_back();
    const auto& v = mesh.triangles[Index(triangle_of[t])];
    for (std::size_t i = 0; i < 3; ++i) {
      behind[i] = tri.segment[i] != Delaunay::kNone || tri.neighbour[i] < 0
                      ? -1
                      : triangle_of[Index(tri.neighbour[i])];
      if (tri.segment[i] == Delaunay::kNone) continue;
      const int tag = from.segments()[Index(tri.segment[i])].tag;
      mesh.boundary.push_back({v[(i + 1) % 3], v[(i + 2) % 3], tag});
    }
  }
  return mesh;
}

// Area that the segments surround; their direction is the caller's, so only its size counts.
double SurroundedArea(const std::vector<Point>& points, const std::vector<Segment>& segments) {
  double twice = 0;
  for (const Segment& s : segments) {
    const Point &a = points[Index(s.a)], &b = points[Index(s.b)];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

}  // namespace

double SizeField::At(const Point& p) const {
  double size = largest;
  for (const Seed& seed : seeds)
    size = std::min(size, seed.size + growth * (p - seed.place).norm());
  return size;
}

TriangleMesh MakeGradedMesh(const std::vector<Point>& points, const std::vector<Segment>& segments,
                            const SizeField& size, int max_points) {
  std::vector<Point> sampled = points;
  std::vector<Segment> pieces = segments;
  SampleBoundary(size, sampled, pieces);
  Delaunay delaunay(sampled, pieces);
  Refinement(delaunay, size, max_points).Run();
  TriangleMesh mesh = Collect(delaunay);
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

}  // namespace palpate::site
