#include "slave/contact/triangle_places.h"

#include <algorithm>
#include <cstddef>

#include <Eigen/Geometry>

#include "slave/contact/surface_contact.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

constexpr double kFlat = 1e-12;  // height over the longest edge that is none

// The sub-triangles' areas by the sign of their normal along `normal`, over the whole.
Vector3d SignedWeights(const Vector3d& p, const Corners& abc, const Vector3d& normal) noexcept {
  const Vector3d a = abc[0] - p, b = abc[1] - p, c = abc[2] - p;
  return Vector3d(normal.dot(b.cross(c)), normal.dot(c.cross(a)), normal.dot(a.cross(b))) /
         normal.squaredNorm();
}

Vector3d UnsignedWeights(const Vector3d& p, const Corners& abc, const Vector3d& normal) noexcept {
  const Vector3d a = abc[0] - p, b = abc[1] - p, c = abc[2] - p;
  return Vector3d(b.cross(c).norm(), c.cross(a).norm(), a.cross(b).norm()) / normal.norm();
}

TrianglePlace OnEdge(const Vector3d& p, const Corners& abc, int from, bool is_forward) noexcept {
  const int to = (from + 1) % 3;
  const int i = is_forward ? from : to, j = is_forward ? to : from;
  const Vector3d &a = abc[static_cast<std::size_t>(i)], &b = abc[static_cast<std::size_t>(j)];
  const Vector3d edge = b - a;
  const double length_squared = edge.squaredNorm();
  const double s =
      length_squared > 0 ? std::clamp((p - a).dot(edge) / length_squared, 0.0, 1.0) : 0.0;
  TrianglePlace place;
  const bool is_inner = s > 0 && s < 1;
  place.feature = is_inner ? TrianglePlace::Feature::kEdge : TrianglePlace::Feature::kCorner;
  place.corner = is_inner ? from : s > 0 ? j : i;
  // A corner is met exactly, so that all triangles round it are equally near.
  place.p = s == 1 ? b : Vector3d(a + s * edge);
  place.weights[i] = 1 - s;
  place.weights[j] = s;
  place.distance_squared = (p - place.p).squaredNorm();
  return place;
}

}  // namespace

Vector3d AreaNormal(const Corners& abc) noexcept {
  const Vector3d u = abc[1] - abc[0], v = abc[2] - abc[0];
  const Vector3d normal = u.cross(v);
  const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
  return normal.norm() > kFlat * longest ? normal : Vector3d(0, 0, 0);
}

TrianglePlace ClosestOnTriangle(const Vector3d& p, const Corners& abc,
                                const std::array<bool, 3>& first_smaller) noexcept {
  TrianglePlace best = OnEdge(p, abc, 0, first_smaller[0]);
  for (int i = 1; i < 3; ++i) {
    const TrianglePlace place = OnEdge(p, abc, i, first_smaller[static_cast<std::size_t>(i)]);
    if (place.distance_squared < best.distance_squared) best = place;
  }
  const Vector3d normal = AreaNormal(abc);
  if (normal == Vector3d(0, 0, 0)) return best;
  const Vector3d weights = SignedWeights(p, abc, normal);
  if (!(weights.minCoeff() > 0)) return best;
  TrianglePlace face;
  face.weights = weights / weights.sum();
  face.p = face.weights[0] * abc[0] + face.weights[1] * abc[1] + face.weights[2] * abc[2];
  face.distance_squared = (p - face.p).squaredNorm();
  return face.distance_squared < best.distance_squared ? face : best;
}

Vector3d TriangleWeights(const Vector3d& p, const Corners& abc, AreaWeights kind) noexcept {
  if (kind == AreaWeights::kClosest) return ClosestOnTriangle(p, abc, {true, true, true}).weights;
  const Vector3d normal = AreaNormal(abc);
  if (normal == Vector3d(0, 0, 0)) return {0, 0, 0};
  return kind == AreaWeights::kSigned ? SignedWeights(p, abc, normal)
                                      : UnsignedWeights(p, abc, normal);
}

}  // namespace palpate
