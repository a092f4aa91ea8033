#include "slave/contact/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "slave/contact/box_tree.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

constexpr int kLeafTriangles = 4;
constexpr double kCoordinateRounding = 1e-13;  // relative to the coordinates involved
constexpr double kFlat = 1e-12;  // height of a degenerate triangle relative to its longest edge

double AngleAt(const Vector3d& corner, const Vector3d& a, const Vector3d& b) {
  const Vector3d u = a - corner, v = b - corner;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

// Returns the barycentric weights: areas of the sub-triangles, with the sign of their normal along
// `normal`, divided by the whole area.
Vector3d SignedWeights(const Vector3d& p, const Corners& abc, const Vector3d& normal) noexcept {
  const Vector3d a = abc[0] - p, b = abc[1] - p, c = abc[2] - p;
  return Vector3d(normal.dot(b.cross(c)), normal.dot(c.cross(a)), normal.dot(a.cross(b))) /
         normal.squaredNorm();
}

TrianglePlace OnEdge(const Vector3d& p, const Corners& abc, int from, bool is_forward) noexcept {
  const int to = (from + 1) % 3;
  const int i = is_forward ? from : to, j = is_forward ? to : from;
  const Vector3d &a = abc[Index(i)], &b = abc[Index(j)];
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

// Returns twice the area times the normal; zero if the triangle is thinner than rounding.
Vector3d AreaNormal(const Corners& abc) noexcept {
  const Vector3d u = abc[1] - abc[0], v = abc[2] - abc[0];
  const Vector3d normal = u.cross(v);
  const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
  return normal.norm() > kFlat * longest ? normal : Vector3d(0, 0, 0);
}

}  // namespace

TrianglePlace ClosestOnTriangle(const Vector3d& p, const Corners& abc,
                                const std::array<bool, 3>& first_smaller) noexcept {
  TrianglePlace best = OnEdge(p, abc, 0, first_smaller[0]);
  for (int i = 1; i < 3; ++i) {
    const TrianglePlace place = OnEdge(p, abc, i, first_smaller[Index(i)]);
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

// Builds axis-aligned boxes over the triangles. The side of a point follows from the normal of the
// nearest feature: that of a triangle, the sum of both normals at an edge, or the sum of all
// normals around a node weighted with their angles (Baerentzen and Aanaes, IEEE Trans. Vis. Comput.
// Graph. 11 (2005) 243-253).
SurfaceContact::SurfaceContact(SurfaceMesh surface) : surface_(std::move(surface)) {
  CheckNodes();
  AddFaces();
  if (faces_.empty()) {
    throw std::invalid_argument("a surface without triangles: expected one that has an area");
  }
  AddNormals();
  boxes_.reserve(2 * faces_.size());
  Build(0, static_cast<int>(faces_.size()));
}

void SurfaceContact::CheckNodes() const {
  const auto count = static_cast<int>(surface_.nodes.size());
  for (const auto& triangle : surface_.triangles) {
    for (const int node : triangle) {
      if (node < 0 || node >= count || !surface_.nodes[Index(node)].allFinite()) {
        throw std::invalid_argument("node " + std::to_string(node) +
                                    " of a surface is missing or not finite");
      }
    }
  }
}

void SurfaceContact::AddFaces() {
  for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
    const auto& nodes = surface_.triangles[t];
    Face face;
    face.edge_normals.fill(Vector3d(0, 0, 0));
    face.triangle = static_cast<int>(t);
    for (std::size_t i = 0; i < 3; ++i) {
      face.corners[i] = surface_.nodes[Index(nodes[i])];
      face.first_smaller[i] = nodes[i] < nodes[(i + 1) % 3];
      reach_ = std::max(reach_, face.corners[i].norm());
    }
    face.normal = AreaNormal(face.corners).stableNormalized();
    if (face.normal != Vector3d(0, 0, 0)) faces_.push_back(face);
  }
}

void SurfaceContact::AddNormals() {
  node_normals_.assign(surface_.nodes.size(), Vector3d(0, 0, 0));
  std::map<std::pair<int, int>, Vector3d> edge_normals;
  const auto edge_of = [&](const Face& face, std::size_t i) {
    const auto& nodes = surface_.triangles[Index(face.triangle)];
    return std::pair<int, int>(std::minmax(nodes[i], nodes[(i + 1) % 3]));
  };
  for (const Face& face : faces_) {
    const auto& nodes = surface_.triangles[Index(face.triangle)];
    for (std::size_t i = 0; i < 3; ++i) {
      const double angle =
          AngleAt(face.corners[i], face.corners[(i + 1) % 3], face.corners[(i + 2) % 3]);
      node_normals_[Index(nodes[i])] += angle * face.normal;
      edge_normals.try_emplace(edge_of(face, i), 0, 0, 0).first->second += face.normal;
    }
  }
  for (Face& face : faces_) {
    for (std::size_t i = 0; i < 3; ++i) face.edge_normals[i] = edge_normals.at(edge_of(face, i));
  }
}

// Splits the faces at their median along the box's longest axis.
int SurfaceContact::Build(int begin, int end) {
  const auto index = boxes_.size();
  Box box{Vector3d::Constant(std::numeric_limits<double>::infinity()),
          Vector3d::Constant(-std::numeric_limits<double>::infinity()), begin, end};
  for (int k = begin; k < end; ++k) {
    for (const Vector3d& corner : FaceAt(k).corners) {
      box.lower = box.lower.cwiseMin(corner);
      box.upper = box.upper.cwiseMax(corner);
    }
  }
  boxes_.push_back(box);
  if (end - begin <= kLeafTriangles) return static_cast<int>(index);
  int axis = 0;
  (box.upper - box.lower).maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  const auto along = [axis](const Face& face) {
    return face.corners[0][axis] + face.corners[1][axis] + face.corners[2][axis];
  };
  std::nth_element(faces_.begin() + begin, faces_.begin() + middle, faces_.begin() + end,
                   [&](const Face& a, const Face& b) { return along(a) < along(b); });
  const int left = Build(begin, middle);
  const int right = Build(middle, end);
  boxes_[index].left = left;
  boxes_[index].right = right;
  return static_cast<int>(index);
}

double SurfaceContact::MinDistanceSquared(const Box& box, const Vector3d& p) const noexcept {
  const Vector3d apart = (box.lower - p).cwiseMax(p - box.upper);
  return (apart.array() - kCoordinateRounding * reach_).max(0.0).matrix().squaredNorm();
}

SurfaceContact::Candidate SurfaceContact::Project(int face, const Vector3d& p) const noexcept {
  const Face& f = FaceAt(face);
  return {face, ClosestOnTriangle(p, f.corners, f.first_smaller),
          std::abs((p - f.corners[0]).dot(f.normal))};
}

// Among equally near faces, which share an edge or a node, prefers the one from whose plane the
// point is farther; then the first one in the mesh.
bool SurfaceContact::IsNearer(const Candidate& one, const Candidate& other) const noexcept {
  if (one.place.distance_squared != other.place.distance_squared) {
    return one.place.distance_squared < other.place.distance_squared;
  }
  if (one.height != other.height) return one.height > other.height;
  return FaceAt(one.face).triangle < FaceAt(other.face).triangle;
}

const Vector3d& SurfaceContact::PseudoNormal(const Candidate& candidate) const noexcept {
  const Face& face = FaceAt(candidate.face);
  const auto corner = Index(candidate.place.corner);
  if (candidate.place.feature == TrianglePlace::Feature::kEdge) return face.edge_normals[corner];
  if (candidate.place.feature == TrianglePlace::Feature::kCorner) {
    return node_normals_[Index(surface_.triangles[Index(face.triangle)][corner])];
  }
  return face.normal;
}

std::optional<TouchedPlace> SurfaceContact::Find(const Vector3d& p, double gate) const noexcept {
  if (!p.allFinite() || !(gate >= 0)) return std::nullopt;
  Candidate best;
  best.place.distance_squared = gate * gate;
  const auto visit = [&](int face) {
    const Candidate candidate = Project(face, p);
    const bool is_first =
        best.face < 0 && candidate.place.distance_squared <= best.place.distance_squared;
    if (is_first || (best.face >= 0 && IsNearer(candidate, best))) best = candidate;
  };
  VisitNearest(
      boxes_, best.place.distance_squared,
      [&](const Box& box) { return MinDistanceSquared(box, p); }, visit);
  if (best.face < 0 || !std::isfinite(best.place.distance_squared)) return std::nullopt;
  const Face& face = FaceAt(best.face);
  TouchedPlace place;
  place.triangle = face.triangle;
  place.p_O = best.place.p;
  place.n_O = face.normal;
  place.weights = best.place.weights;
  place.distance = std::sqrt(best.place.distance_squared);
  place.inside = (p - best.place.p).dot(PseudoNormal(best)) < 0;
  return place;
}

}  // namespace palpate
