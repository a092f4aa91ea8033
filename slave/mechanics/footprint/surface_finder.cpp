#include "slave/mechanics/footprint/surface_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// As in surface_patch.cpp.
constexpr double kOnNode = 1e-6;   // of the diagonal
constexpr double kSlack = 1e-9;    // relative, of the patch's radius
constexpr double kSameSide = 0.5;  // cosine of the angle between normals
constexpr double kOnEdge = 1e-9;   // barycentric weight

}  // namespace

SurfaceFinder::SurfaceFinder(SurfaceMesh surface)
    : surface_(std::move(surface)), diagonal_(Diagonal(surface_.nodes)) {
  const int triangles = static_cast<int>(surface_.triangles.size());
  first_of_node_.assign(surface_.nodes.size() + 1, 0);
  for (int t = 0; t < triangles; ++t) {
    normals_.push_back(Normal(surface_, t));
    centroids_.push_back(Centroid(surface_, t));
    areas_.push_back(Area(surface_, t));
    for (const int node : surface_.triangles[Index(t)]) ++first_of_node_[Index(node) + 1];
  }
  for (std::size_t n = 1; n < first_of_node_.size(); ++n)
    first_of_node_[n] += first_of_node_[n - 1];
  triangles_of_node_.resize(3 * surface_.triangles.size());
  std::vector<int> next(first_of_node_);
  for (int t = 0; t < triangles; ++t) {
    for (const int node : surface_.triangles[Index(t)]) {
      triangles_of_node_[Index(next[Index(node)]++)] = t;
    }
  }
  seen_.assign(surface_.nodes.size(), 0);
  patch_.nodes.reserve(surface_.nodes.size());
  patch_.triangles.reserve(surface_.triangles.size());
}

std::span<const int> SurfaceFinder::TrianglesOf(int node) const {
  const int first = first_of_node_[Index(node)];
  return std::span(triangles_of_node_)
      .subspan(Index(first), Index(first_of_node_[Index(node) + 1] - first));
}

std::optional<SurfacePlace> SurfaceFinder::Find(const Contact& contact) const {
  if (contact.element < 0) return FindPlace(surface_, contact.p_O);
  if (contact.element >= static_cast<int>(surface_.triangles.size())) return std::nullopt;
  return OnTriangle(contact.element, contact.p_O);
}

std::optional<SurfacePlace> SurfaceFinder::OnTriangle(int triangle, const Vector3d& p_O) const {
  const auto& corners = surface_.triangles[Index(triangle)];
  const double near = kOnNode * diagonal_;
  SurfacePlace place;
  place.triangle = triangle;
  for (int v = 0; v < 3; ++v) {
    const int node = corners[Index(v)];
    const double distance2 = (surface_.nodes[Index(node)] - p_O).squaredNorm();
    if (distance2 > near * near) continue;
    place.node = node;
    place.weights = Vector3d::Unit(v);
    place.distance = std::sqrt(distance2);
    return place;
  }
  const Vector3d &a = surface_.nodes[Index(corners[0])], &b = surface_.nodes[Index(corners[1])],
                 &c = surface_.nodes[Index(corners[2])];
  const Vector3d area = (b - a).cross(c - a);
  const Vector3d from_a = p_O - a;
  const double height = from_a.dot(area) / area.norm();
  place.weights[1] = from_a.cross(c - a).dot(area) / area.squaredNorm();
  place.weights[2] = (b - a).cross(from_a).dot(area) / area.squaredNorm();
  place.weights[0] = 1 - place.weights[1] - place.weights[2];
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  if (place.weights.minCoeff() >= 0 && std::abs(height) <= 0.5 * longest) {
    place.distance = std::abs(height);
    return place;
  }
  const auto found = FindPlace({{a, b, c}, {{0, 1, 2}}}, p_O);  // beside the triangle
  if (!found) return std::nullopt;
  place.weights = found->weights;
  place.distance = found->distance;
  return place;
}

Vector3d SurfaceFinder::NormalAt(const SurfacePlace& place) const {
  const auto& corners = surface_.triangles[Index(place.triangle)];
  std::array<int, 3> touched{place.node, -1, -1};
  std::size_t count = 1;
  if (place.node < 0) {
    count = 0;
    for (int v = 0; v < 3; ++v) {
      if (place.weights[v] > kOnEdge) touched[count++] = corners[Index(v)];
    }
  }
  Vector3d sum = Vector3d::Zero();
  for (const int t : TrianglesOf(touched[0])) {
    const auto& nodes = surface_.triangles[Index(t)];
    const bool all = std::all_of(touched.begin(), touched.begin() + static_cast<long>(count),
                                 [&](int node) { return std::ranges::count(nodes, node) > 0; });
    if (all) sum += normals_[Index(t)];
  }
  const double length = sum.norm();
  return length > kOnEdge ? Vector3d(sum / length) : Vector3d::Zero();
}

void SurfaceFinder::FindPatch(const SurfacePlace& place, const Vector3d& p_O, double width) {
  const Vector3d facing = NormalAt(place);
  const double radius = 0.5 * width * (1 + kSlack);
  ++patches_;
  patch_.nodes.clear();
  patch_.triangles.clear();
  patch_.disc = {};
  patch_.node_area = patch_.triangle_area = 0;
  const int triangles = static_cast<int>(normals_.size());
  for (int t = 0; t < triangles; ++t) {
    if (normals_[Index(t)].dot(facing) < kSameSide) continue;
    const DiscShare disc = DiscOnTriangle(surface_, t, p_O, radius);
    patch_.disc.area += disc.area;
    patch_.disc.rim += disc.rim;
    if ((centroids_[Index(t)] - p_O).norm() <= radius) AddTriangle(t);
    for (const int node : surface_.triangles[Index(t)]) {
      if ((surface_.nodes[Index(node)] - p_O).norm() > radius) continue;
      patch_.node_area += areas_[Index(t)] / 3;
      if (seen_[Index(node)] == patches_) continue;
      seen_[Index(node)] = patches_;
      patch_.nodes.push_back(node);
    }
  }
  std::ranges::sort(patch_.nodes);
  if (patch_.triangles.empty()) AddTriangle(place.triangle);
}

void SurfaceFinder::AddTriangle(int triangle) {
  patch_.triangles.push_back(triangle);
  patch_.triangle_area += areas_[Index(triangle)];
}

}  // namespace palpate
