#include "slave/reference/planar/delaunay.h"

#include <stdexcept>
#include <string>

#include <Eigen/LU>

#include "shared/geometry/index.h"

namespace palpate::site {
namespace {

using Point = Eigen::Vector2d;

int After(int i) {
  return i == 2 ? 0 : i + 1;
}
int Before(int i) {
  return i == 0 ? 2 : i - 1;
}

}  // namespace

double Orientation(const Point& a, const Point& b, const Point& c) {
  const auto dx = static_cast<long double>(a.x()) - c.x();
  const auto dy = static_cast<long double>(a.y()) - c.y();
  const auto ex = static_cast<long double>(b.x()) - c.x();
  const auto ey = static_cast<long double>(b.y()) - c.y();
  return static_cast<double>(dx * ey - dy * ex);
}

Point Circumcentre(const Point& a, const Point& b, const Point& c) {
  const Point u = b - a, v = c - a;
  const double d = 2 * (u.x() * v.y() - u.y() * v.x());
  const double uu = u.squaredNorm(), vv = v.squaredNorm();
  return a + Point(v.y() * uu - u.y() * vv, u.x() * vv - v.x() * uu) / d;
}

Delaunay::Delaunay(const std::vector<Point>& points, const std::vector<Segment>& segments) {
  MakeBox();
  for (const Point& p : points) InsertFree(p);
  for (const Segment& s : segments) {
    segments_.push_back({s.a + kBoxPoints, s.b + kBoxPoints, s.tag});
  }
  RecoverSegments();
  MarkInside();
}

// Two triangles around everything: coordinates are of order one, so ten is far away.
void Delaunay::MakeBox() {
  points_ = {{-10, -10}, {10, -10}, {10, 10}, {-10, 10}};
  point_triangle_ = {0, 0, 0, 1};
  fan_.assign(kBoxPoints, kNone);
  triangles_.resize(2);
  triangles_[0].vertex = {0, 1, 2};
  triangles_[0].neighbour = {kNone, 1, kNone};
  triangles_[1].vertex = {0, 2, 3};
  triangles_[1].neighbour = {kNone, kNone, 0};
  in_cavity_.assign(2, 0);
  created_ = {0};
}

void Delaunay::InsertFree(const Point& p) {
  if (!Prepare(p, created_.back())) throw std::runtime_error("mesh: boundary segments cross");
  Commit();
}

bool Delaunay::InCircle(const Triangle& t, const Point& p) const {
  using Real = long double;
  std::array<Real, 3> x{}, y{}, w{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Point& v = points_[Index(t.vertex[i])];
    x[i] = static_cast<Real>(v.x()) - p.x();
    y[i] = static_cast<Real>(v.y()) - p.y();
    w[i] = x[i] * x[i] + y[i] * y[i];
  }
  const Real det = w[0] * (x[1] * y[2] - y[1] * x[2]) - w[1] * (x[0] * y[2] - y[0] * x[2]) +
                   w[2] * (x[0] * y[1] - y[0] * x[1]);
  return det > 0;
}

// Visibility walk. Ends in the triangle that holds `p`, or before a segment that hides it.
int Delaunay::Walk(const Point& p, int from) {
  blocking_segment_ = kNone;
  int came_from = kNone;
  std::size_t steps = 0;
  for (int t = from;;) {
    if (++steps > triangles_.size() + 100) throw std::runtime_error("mesh: walk without end");
    const Triangle& tri = triangles_[Index(t)];
    int next = kNone;
    for (std::size_t i = 0; i < 3; ++i) {
      const int k = static_cast<int>(i);
      if (tri.neighbour[i] == came_from && came_from != kNone) continue;
      const Point& a = points_[Index(tri.vertex[Index(After(k))])];
      const Point& b = points_[Index(tri.vertex[Index(Before(k))])];
      if (Orientation(a, b, p) >= 0) continue;
      if (tri.segment[i] != kNone) {
        blocking_segment_ = tri.segment[i];
        return t;
      }
      next = tri.neighbour[i];
      if (next == kNone) throw std::runtime_error("mesh: point outside the surrounding box");
      break;
    }
    if (next == kNone) return t;
    came_from = t;
    t = next;
  }
}

void Delaunay::AddToCavity(int t) {
  in_cavity_[Index(t)] = stamp_;
  cavity_.push_back(t);
}

// All triangles around the seeds whose circumcircle holds `p`, never across a segment.
void Delaunay::GrowCavity(const Point& p, std::vector<int> seeds, int passable_segment) {
  ++stamp_;
  cavity_.clear();
  for (const int t : seeds) AddToCavity(t);
  for (std::size_t k = 0; k < cavity_.size(); ++k) {
    const Triangle& tri = triangles_[Index(cavity_[k])];
    for (std::size_t i = 0; i < 3; ++i) {
      const int n = tri.neighbour[i];
      if (n == kNone || in_cavity_[Index(n)] == stamp_) continue;
      if (tri.segment[i] != kNone && tri.segment[i] != passable_segment) continue;
      if (InCircle(triangles_[Index(n)], p)) AddToCavity(n);
    }
  }
  CollectRim();
  // Rounding may leave a rim edge that the point sees edge-on: take in the triangle behind it.
  for (int bad = BadRimEdge(p); bad != kNone; bad = BadRimEdge(p)) {
    const RimEdge edge = rim_[Index(bad)];
    if (edge.outer == kNone || edge.segment != kNone) {
      throw std::runtime_error("mesh: coinciding or collinear boundary points");
    }
    AddToCavity(edge.outer);
    CollectRim();
  }
}

void Delaunay::CollectRim() {
  rim_.clear();
  for (const int t : cavity_) {
    const Triangle& tri = triangles_[Index(t)];
    for (std::size_t i = 0; i < 3; ++i) {
      const int n = tri.neighbour[i];
      if (n != kNone && in_cavity_[Index(n)] == stamp_) continue;
      int back = kNone;
      if (n != kNone) {
        const auto& behind = triangles_[Index(n)].neighbour;
        back = behind[0] == t ? 0 : behind[1] == t ? 1 : 2;
      }
      const int k = static_cast<int>(i);
      rim_.push_back({tri.vertex[Index(After(k))], tri.vertex[Index(Before(k))], n, back,
                      tri.segment[i], tri.inside});
    }
  }
}

int Delaunay::BadRimEdge(const Point& p) const {
  for (std::size_t k = 0; k < rim_.size(); ++k) {
    const Point& a = points_[Index(rim_[k].a)];
    const Point& b = points_[Index(rim_[k].b)];
    if (Orientation(a, b, p) <= 1e-13 * (b - a).squaredNorm()) return static_cast<int>(k);
  }
  return kNone;
}

bool Delaunay::Prepare(const Point& p, int from) {
  encroached_.clear();
  const int t = Walk(p, from);
  if (blocking_segment_ != kNone) return false;
  for (const int v : triangles_[Index(t)].vertex) {
    if (points_[Index(v)] == p) {
      throw std::runtime_error("mesh: coinciding points");
    }
  }
  GrowCavity(p, {t}, kNone);
  for (const RimEdge& e : rim_) {
    if (e.segment == kNone) continue;
    const Point a = points_[Index(e.a)] - p;
    const Point b = points_[Index(e.b)] - p;
    if (a.dot(b) < 0) encroached_.push_back(e.segment);
  }
  prepared_ = p;
  return true;
}

int Delaunay::NewTriangle() {
  if (free_.empty()) {
    triangles_.emplace_back();
    in_cavity_.push_back(0);
    return static_cast<int>(triangles_.size()) - 1;
  }
  const int t = free_.back();
  free_.pop_back();
  Triangle& tri = triangles_[Index(t)];
  tri = Triangle{.generation = tri.generation + 1};
  return t;
}

void Delaunay::Commit() {
  points_.push_back(prepared_);
  point_triangle_.push_back(kNone);
  fan_.push_back(kNone);
  Fill(static_cast<int>(points_.size()) - 1);
}

// Replaces the cavity by a fan of triangles from `apex` to the rim.
void Delaunay::Fill(int apex) {
  for (const int t : cavity_) {
    triangles_[Index(t)].alive = false;
    free_.push_back(t);
  }
  created_.clear();
  for (const RimEdge& e : rim_) {
    const int t = NewTriangle();
    Triangle& tri = triangles_[Index(t)];
    tri.vertex = {apex, e.a, e.b};
    tri.neighbour = {e.outer, kNone, kNone};
    tri.segment = {e.segment, kNone, kNone};
    tri.inside = e.inside;
    if (e.outer != kNone) {
      triangles_[Index(e.outer)].neighbour[Index(e.outer_edge)] = t;
    }
    fan_[Index(e.a)] = t;
    for (const int v : tri.vertex) point_triangle_[Index(v)] = t;
    created_.push_back(t);
  }
  for (const int t : created_) {
    Triangle& tri = triangles_[Index(t)];
    const int next = fan_[Index(tri.vertex[2])];
    tri.neighbour[1] = next;
    triangles_[Index(next)].neighbour[2] = t;
  }
}

// The triangle with edge a -> b and the index of that edge; kNone where there is no such edge.
int Delaunay::EdgeTriangle(int a, int b, int* edge) const {
  const int start = point_triangle_[Index(a)];
  int t = start;
  do {
    const Triangle& tri = triangles_[Index(t)];
    const int at = tri.vertex[0] == a ? 0 : tri.vertex[1] == a ? 1 : 2;
    if (tri.vertex[Index(After(at))] == b) {
      *edge = Before(at);
      return t;
    }
    t = tri.neighbour[Index(After(at))];  // behind the edge that ends in a
  } while (t != start && t != kNone);
  return kNone;
}

void Delaunay::RecoverSegments() {
  const std::size_t limit = 20 * segments_.size() + 1000;
  int edge = 0;
  for (bool all = false; !all;) {
    all = true;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const auto [a, b, tag] = segments_[s];
      if (EdgeTriangle(a, b, &edge) != kNone) continue;
      all = false;
      const int middle = static_cast<int>(points_.size());
      InsertFree(0.5 * (points_[Index(a)] + points_[Index(b)]));
      segments_[s].b = middle;
      segments_.push_back({middle, b, tag});
      if (segments_.size() > limit) throw std::runtime_error("mesh: boundary segments cross");
    }
  }
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    for (const auto& [a, b] :
         {std::pair(segments_[s].a, segments_[s].b), std::pair(segments_[s].b, segments_[s].a)}) {
      const int t = EdgeTriangle(a, b, &edge);
      triangles_[Index(t)].segment[Index(edge)] = static_cast<int>(s);
    }
  }
}

// Flood from the box; every segment crossed changes sides.
void Delaunay::MarkInside() {
  std::vector<char> seen(triangles_.size(), 0);
  std::vector<int> stack{point_triangle_[0]};
  triangles_[Index(stack[0])].inside = false;
  seen[Index(stack[0])] = 1;
  while (!stack.empty()) {
    const Triangle& tri = triangles_[Index(stack.back())];
    stack.pop_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const int n = tri.neighbour[i];
      if (n == kNone || seen[Index(n)] != 0) continue;
      seen[Index(n)] = 1;
      triangles_[Index(n)].inside = tri.inside != (tri.segment[i] != kNone);
      stack.push_back(n);
    }
  }
}

void Delaunay::SplitSegment(int s) {
  const auto [a, b, tag] = segments_[Index(s)];
  int edge = 0;
  const int left = EdgeTriangle(a, b, &edge), right = EdgeTriangle(b, a, &edge);
  prepared_ = 0.5 * (points_[Index(a)] + points_[Index(b)]);
  GrowCavity(prepared_, {left, right}, s);
  const int middle = static_cast<int>(points_.size());
  Commit();
  segments_[Index(s)].b = middle;
  segments_.push_back({middle, b, tag});
  const int second = static_cast<int>(segments_.size()) - 1;
  for (const auto& [from, to, id] :
       {std::tuple(a, middle, s), std::tuple(middle, a, s), std::tuple(middle, b, second),
        std::tuple(b, middle, second)}) {
    const int t = EdgeTriangle(from, to, &edge);
    triangles_[Index(t)].segment[Index(edge)] = id;
  }
}

}  // namespace palpate::site
