#include "shared/mesh/disc_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <set>

#include <Eigen/Geometry>

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Relative to the diagonal: rounding of coordinates in a text file.
constexpr double kOnNode = 1e-6;
constexpr double kEquallyNear = 1e-9;  // of the diagonal
constexpr double kSlack = 1e-9;        // relative, of the patch's radius
constexpr double kSameSide = 0.5;      // cosine of the angle between normals

struct Corners {
  const Vector3d &a, &b, &c;
};

Corners CornersOf(const SurfaceMesh& surface, int triangle) {
  const auto& [a, b, c] = surface.triangles[static_cast<std::size_t>(triangle)];
  const auto p = [&](int i) -> const Vector3d& {
    return surface.nodes[static_cast<std::size_t>(i)];
  };
  return {p(a), p(b), p(c)};
}

// Barycentric weights of the point of triangle a b c that is nearest to p, by the Voronoi regions
// of its corners and edges.
Vector3d NearestWeights(const Corners& t, const Vector3d& p) {
  const Vector3d ab = t.b - t.a, ac = t.c - t.a;
  const double a1 = ab.dot(p - t.a), a2 = ac.dot(p - t.a);
  if (a1 <= 0 && a2 <= 0) return {1, 0, 0};
  const double b1 = ab.dot(p - t.b), b2 = ac.dot(p - t.b);
  if (b1 >= 0 && b2 <= b1) return {0, 1, 0};
  const double w_c = a1 * b2 - b1 * a2;
  if (w_c <= 0 && a1 >= 0 && b1 <= 0) return {1 - a1 / (a1 - b1), a1 / (a1 - b1), 0};
  const double c1 = ab.dot(p - t.c), c2 = ac.dot(p - t.c);
  if (c2 >= 0 && c1 <= c2) return {0, 0, 1};
  const double w_b = c1 * a2 - a1 * c2;
  if (w_b <= 0 && a2 >= 0 && c2 <= 0) return {1 - a2 / (a2 - c2), 0, a2 / (a2 - c2)};
  const double w_a = b1 * c2 - c1 * b2;
  if (w_a <= 0 && b2 - b1 >= 0 && c1 - c2 >= 0) {
    const double v = (b2 - b1) / ((b2 - b1) + (c1 - c2));
    return {0, 1 - v, v};
  }
  const double sum = w_a + w_b + w_c;
  return {w_a / sum, w_b / sum, w_c / sum};
}

double MaxEdgeLength(const Corners& t) {
  return std::max({(t.b - t.a).norm(), (t.c - t.b).norm(), (t.a - t.c).norm()});
}

int NearestNode(const SurfaceMesh& surface, const Vector3d& p, double within) {
  int nearest = -1;
  double least = within * within;
  for (std::size_t i = 0; i < surface.nodes.size(); ++i) {
    const double d = (surface.nodes[i] - p).squaredNorm();
    if (d <= least) least = d, nearest = static_cast<int>(i);
  }
  return nearest;
}

// Returns whether the triangle's bounding box is farther than `far` from p.
bool IsBeyond(const Corners& t, const Vector3d& p, double far) {
  const Vector3d low = t.a.cwiseMin(t.b).cwiseMin(t.c), high = t.a.cwiseMax(t.b).cwiseMax(t.c);
  return (low - p).cwiseMax(p - high).cwiseMax(0).squaredNorm() > far * far;
}

double Cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

struct Sector {
  double area = 0, rim = 0;
  Vector2d first{0, 0};
};

// Adds the part of the triangle 0 a b in the circle of radius r around 0, negative where it is
// clockwise: triangles over the part of a b inside, sectors beside it.
void AddSector(const Vector2d& a, const Vector2d& b, double r, Sector* share) {
  const auto arc = [&](const Vector2d& from, const Vector2d& to) {
    const double angle = std::atan2(Cross(from, to), from.dot(to));
    share->area += r * r * angle / 2;
    share->rim += angle;
    const Vector2d chord = to.normalized() - from.normalized();
    share->first += r * r * r / 3 * Vector2d(chord.y(), -chord.x());
  };
  const Vector2d ab = b - a;
  const double length = ab.squaredNorm(), along = -a.dot(ab) / length;  // foot of 0 on the line
  const double reach = (r * r - Cross(a, ab) * Cross(a, ab) / length) / length;
  const double from = along - std::sqrt(std::max(0.0, reach));
  const double to = along + std::sqrt(std::max(0.0, reach));
  if (!(reach > 0) || from >= 1 || to <= 0) return arc(a, b);
  const Vector2d in = a + std::max(0.0, from) * ab, out = a + std::min(1.0, to) * ab;
  share->area += Cross(in, out) / 2;
  share->first += Cross(in, out) / 6 * (in + out);
  if (from > 0) arc(a, in);
  if (to < 1) arc(out, b);
}

}  // namespace

NodeTriangles::NodeTriangles(const SurfaceMesh& surface)
    : first_(surface.nodes.size() + 1, 0), triangles_(3 * surface.triangles.size()) {
  for (const auto& triangle : surface.triangles) {
    for (const int node : triangle) ++first_[static_cast<std::size_t>(node) + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<int> next(first_);
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    for (const int node : surface.triangles[static_cast<std::size_t>(t)]) {
      triangles_[static_cast<std::size_t>(next[static_cast<std::size_t>(node)]++)] = t;
    }
  }
}

Vector3d Normal(const SurfaceMesh& surface, int triangle) {
  const Corners t = CornersOf(surface, triangle);
  const Vector3d n = (t.b - t.a).cross(t.c - t.a);
  const double length = n.norm();
  return length > 0 ? Vector3d(n / length) : Vector3d::Zero();
}

double Area(const SurfaceMesh& surface, int triangle) {
  const Corners t = CornersOf(surface, triangle);
  return 0.5 * (t.b - t.a).cross(t.c - t.a).norm();
}

Vector3d Centroid(const SurfaceMesh& surface, int triangle) {
  const Corners t = CornersOf(surface, triangle);
  return (t.a + t.b + t.c) / 3;
}

std::optional<SurfacePlace> FindPlace(const SurfaceMesh& surface, const Vector3d& p_O) {
  if (!p_O.allFinite() || surface.triangles.empty()) return std::nullopt;
  const double diagonal = Diagonal(surface.nodes);
  SurfacePlace place;
  place.distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < static_cast<int>(surface.triangles.size()); ++i) {
    const Corners t = CornersOf(surface, i);
    if (IsBeyond(t, p_O, place.distance + 2 * kEquallyNear * diagonal)) continue;
    const Vector3d weights = NearestWeights(t, p_O);
    const double d = (weights[0] * t.a + weights[1] * t.b + weights[2] * t.c - p_O).norm();
    if (!(d <= place.distance + kEquallyNear * diagonal)) continue;
    place.triangle = i;
    place.weights = weights;
    place.distance = std::min(d, place.distance);
  }
  place.node = NearestNode(surface, p_O, kOnNode * diagonal);
  if (place.node >= 0) {
    place.distance = (surface.nodes[static_cast<std::size_t>(place.node)] - p_O).norm();
  } else if (place.distance > 0.5 * MaxEdgeLength(CornersOf(surface, place.triangle))) {
    return std::nullopt;
  }
  return place;
}

DiscShare DiscOnTriangle(const SurfaceMesh& surface, int triangle, const Vector3d& p_O,
                         double radius) {
  const Corners t = CornersOf(surface, triangle);
  const Vector3d n = Normal(surface, triangle);
  const double height = n.dot(p_O - t.a);
  const double squared = radius * radius - height * height;
  if (n.isZero(0) || !(squared > 0) || (t.a - p_O).norm() > radius + MaxEdgeLength(t)) return {};
  const Vector3d along = (t.b - t.a).normalized(), across = n.cross(along);
  const auto in_plane = [&](const Vector3d& p) -> Vector2d {
    return {along.dot(p - p_O), across.dot(p - p_O)};
  };
  const std::array<Vector2d, 3> corners{in_plane(t.a), in_plane(t.b), in_plane(t.c)};
  Sector share;
  for (std::size_t i = 0; i < 3; ++i) {
    AddSector(corners[i], corners[(i + 1) % 3], std::sqrt(squared), &share);
  }
  return {share.area, share.rim,
          share.first.x() * along + share.first.y() * across - share.area * height * n};
}

DiscPatch PatchAt(const SurfaceMesh& surface, const SurfacePlace& place, const Vector3d& p_O,
                  double width) {
  const double radius = 0.5 * width * (1 + kSlack);
  const double near = kEquallyNear * Diagonal(surface.nodes);
  Vector3d facing = Vector3d::Zero();
  const int count = static_cast<int>(surface.triangles.size());
  for (int i = 0; i < count; ++i) {
    const Corners t = CornersOf(surface, i);
    const Vector3d weights = NearestWeights(t, p_O);
    const double d = (weights[0] * t.a + weights[1] * t.b + weights[2] * t.c - p_O).norm();
    if (d <= place.distance + near) facing += Normal(surface, i);
  }
  facing.normalize();
  DiscPatch patch;
  std::set<int> nodes;
  const NodeTriangles around(surface);
  std::vector<bool> is_reached(surface.triangles.size(), false);
  std::vector<int> searched;
  const auto reach_around = [&](int t) {
    for (const int node : surface.triangles[static_cast<std::size_t>(t)]) {
      for (const int i : around.Of(node)) {
        if (is_reached[static_cast<std::size_t>(i)]) continue;
        is_reached[static_cast<std::size_t>(i)] = true;
        if (Normal(surface, i).dot(facing) >= kSameSide) searched.push_back(i);
      }
    }
  };
  reach_around(place.triangle);
  for (std::size_t next = 0; next < searched.size(); ++next) {
    const int i = searched[next];
    const DiscShare disc = DiscOnTriangle(surface, i, p_O, radius);
    patch.disc.area += disc.area;
    patch.disc.rim += disc.rim;
    patch.disc.first += disc.first;
    const double area = Area(surface, i);
    if ((Centroid(surface, i) - p_O).norm() <= radius) {
      patch.triangles.push_back(i);
      patch.triangle_area += area;
    }
    bool is_within = disc.area > 0;
    for (const int node : surface.triangles[static_cast<std::size_t>(i)]) {
      if ((surface.nodes[static_cast<std::size_t>(node)] - p_O).norm() > radius) continue;
      is_within = true;
      nodes.insert(node);
      patch.node_area += area / 3;
    }
    if (is_within) reach_around(i);
  }
  std::ranges::sort(patch.triangles);
  if (patch.triangles.empty()) {
    patch.triangles.push_back(place.triangle);
    patch.triangle_area = Area(surface, place.triangle);
  }
  patch.nodes.assign(nodes.begin(), nodes.end());
  return patch;
}

}  // namespace palpate
