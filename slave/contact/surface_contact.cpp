#include "slave/contact/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "slave/contact/box_stack.h"
#include "slave/contact/triangle_places.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr int kLeafSize = 4;
constexpr int kDeepest = 64;         // halving: 2^32 triangles need 32 levels
constexpr double kRounding = 1e-13;  // of the coordinates at hand

using Stack = BoxStack<kDeepest>;

struct Face {
  int triangle = -1;
  std::array<Vector3d, 3> corners;
  std::array<bool, 3> first_smaller{};   // by node number, edge i to i + 1
  Vector3d normal{0, 0, 0};              // unit
  std::array<Vector3d, 3> edge_normals;  // not unit
};

// Leaves own faces, others two boxes.
struct Box {
  Vector3d lower, upper;
  int begin, end;  // range of faces
  int left = -1, right = -1;
};

double AngleAt(const Vector3d& corner, const Vector3d& a, const Vector3d& b) {
  const Vector3d u = a - corner, v = b - corner;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

}  // namespace

// Boxes along the axes over the triangles. The side of a point is told by the normal of what it is
// closest to: of a triangle, the sum of both of an edge, the sum of all round a node weighted with
// their angles there (Baerentzen and Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243-253).
struct SurfaceContact::Tree {
  explicit Tree(SurfaceMesh mesh);

  [[nodiscard]] std::optional<TouchedPlace> Find(const Vector3d& p, double gate) const noexcept;

 private:
  friend class SurfaceContact;
  struct Candidate {
    int face = -1;
    TrianglePlace place;
    double height = 0;  // of the point over the face's plane [m], unsigned
  };

  void CheckNodes() const;
  void AddFaces();
  void AddNormals();
  int Build(int begin, int end);
  [[nodiscard]] double LeastDistanceSquared(const Box& box, const Vector3d& p) const noexcept;
  [[nodiscard]] Candidate Project(int face, const Vector3d& p) const noexcept;
  [[nodiscard]] bool IsNearer(const Candidate& one, const Candidate& other) const noexcept;
  [[nodiscard]] const Vector3d& PseudoNormal(const Candidate& candidate) const noexcept;
  [[nodiscard]] const Face& FaceAt(int i) const noexcept {
    return faces[static_cast<std::size_t>(i)];
  }

  SurfaceMesh surface;
  std::vector<Face> faces;  // those with an area; without one, neighbours hold every point
  std::vector<Box> boxes;   // boxes[0] is the root
  std::vector<Vector3d> node_normals;  // not unit
  double reach = 0;                    // largest distance of a node from the origin [m]
};

SurfaceContact::Tree::Tree(SurfaceMesh mesh) : surface(std::move(mesh)) {
  CheckNodes();
  AddFaces();
  if (faces.empty()) {
    throw std::invalid_argument("a surface without triangles: accepted is one that has an area");
  }
  AddNormals();
  boxes.reserve(2 * faces.size());
  Build(0, static_cast<int>(faces.size()));
}

void SurfaceContact::Tree::CheckNodes() const {
  const auto count = static_cast<int>(surface.nodes.size());
  for (const auto& triangle : surface.triangles) {
    for (const int node : triangle) {
      if (node < 0 || node >= count || !surface.nodes[static_cast<std::size_t>(node)].allFinite()) {
        throw std::invalid_argument("node " + std::to_string(node) +
                                    " of a surface is missing or not finite");
      }
    }
  }
}

void SurfaceContact::Tree::AddFaces() {
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& nodes = surface.triangles[t];
    Face face;
    face.triangle = static_cast<int>(t);
    for (std::size_t i = 0; i < 3; ++i) {
      face.corners[i] = surface.nodes[static_cast<std::size_t>(nodes[i])];
      face.first_smaller[i] = nodes[i] < nodes[(i + 1) % 3];
      reach = std::max(reach, face.corners[i].norm());
    }
    face.normal = AreaNormal(face.corners).stableNormalized();
    if (face.normal != Vector3d(0, 0, 0)) faces.push_back(face);
  }
}

void SurfaceContact::Tree::AddNormals() {
  node_normals.assign(surface.nodes.size(), Vector3d(0, 0, 0));
  std::map<std::pair<int, int>, Vector3d> edge_normals;
  const auto edge_of = [&](const Face& face, std::size_t i) {
    const auto& nodes = surface.triangles[static_cast<std::size_t>(face.triangle)];
    return std::pair<int, int>(std::minmax(nodes[i], nodes[(i + 1) % 3]));
  };
  for (const Face& face : faces) {
    const auto& nodes = surface.triangles[static_cast<std::size_t>(face.triangle)];
    for (std::size_t i = 0; i < 3; ++i) {
      const double angle =
          AngleAt(face.corners[i], face.corners[(i + 1) % 3], face.corners[(i + 2) % 3]);
      node_normals[static_cast<std::size_t>(nodes[i])] += angle * face.normal;
      edge_normals.try_emplace(edge_of(face, i), 0, 0, 0).first->second += face.normal;
    }
  }
  for (Face& face : faces) {
    for (std::size_t i = 0; i < 3; ++i) face.edge_normals[i] = edge_normals.at(edge_of(face, i));
  }
}

// Splits the faces at their median along the box's longest axis.
int SurfaceContact::Tree::Build(int begin, int end) {
  const auto index = boxes.size();
  Box box{Vector3d::Constant(std::numeric_limits<double>::infinity()),
          Vector3d::Constant(-std::numeric_limits<double>::infinity()), begin, end};
  for (int k = begin; k < end; ++k) {
    for (const Vector3d& corner : FaceAt(k).corners) {
      box.lower = box.lower.cwiseMin(corner);
      box.upper = box.upper.cwiseMax(corner);
    }
  }
  boxes.push_back(box);
  if (end - begin <= kLeafSize) return static_cast<int>(index);
  int axis = 0;
  (box.upper - box.lower).maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  const auto along = [axis](const Face& face) {
    return face.corners[0][axis] + face.corners[1][axis] + face.corners[2][axis];
  };
  std::nth_element(faces.begin() + begin, faces.begin() + middle, faces.begin() + end,
                   [&](const Face& a, const Face& b) { return along(a) < along(b); });
  const int left = Build(begin, middle);
  const int right = Build(middle, end);
  boxes[index].left = left;
  boxes[index].right = right;
  return static_cast<int>(index);
}

double SurfaceContact::Tree::LeastDistanceSquared(const Box& box,
                                                  const Vector3d& p) const noexcept {
  const Vector3d apart = (box.lower - p).cwiseMax(p - box.upper);
  return (apart.array() - kRounding * reach).max(0.0).matrix().squaredNorm();
}

SurfaceContact::Tree::Candidate SurfaceContact::Tree::Project(int face,
                                                              const Vector3d& p) const noexcept {
  const Face& f = FaceAt(face);
  return {face, ClosestOnTriangle(p, f.corners, f.first_smaller),
          std::abs((p - f.corners[0]).dot(f.normal))};
}

// Of equally near faces, that share an edge or a node, the one the point lies farther in front of
// or behind; then that which comes first in the mesh.
bool SurfaceContact::Tree::IsNearer(const Candidate& one, const Candidate& other) const noexcept {
  if (one.place.distance_squared != other.place.distance_squared) {
    return one.place.distance_squared < other.place.distance_squared;
  }
  if (one.height != other.height) return one.height > other.height;
  return FaceAt(one.face).triangle < FaceAt(other.face).triangle;
}

const Vector3d& SurfaceContact::Tree::PseudoNormal(const Candidate& candidate) const noexcept {
  const Face& face = FaceAt(candidate.face);
  const auto corner = static_cast<std::size_t>(candidate.place.corner);
  switch (candidate.place.feature) {
    case TrianglePlace::Feature::kEdge:
      return face.edge_normals[corner];
    case TrianglePlace::Feature::kCorner:
      return node_normals[static_cast<std::size_t>(
          surface.triangles[static_cast<std::size_t>(face.triangle)][corner])];
    case TrianglePlace::Feature::kFace:
      break;
  }
  return face.normal;
}

std::optional<TouchedPlace> SurfaceContact::Tree::Find(const Vector3d& p,
                                                       double gate) const noexcept {
  if (!p.allFinite() || !(gate >= 0)) return std::nullopt;
  Candidate best;
  best.place.distance_squared = gate * gate;
  const auto visit = [&](int face) {
    const Candidate candidate = Project(face, p);
    const bool is_first =
        best.face < 0 && candidate.place.distance_squared <= best.place.distance_squared;
    if (is_first || (best.face >= 0 && IsNearer(candidate, best))) best = candidate;
  };
  Stack stack;
  for (stack.Push(0); !stack.empty();) {
    const Box& box = boxes[static_cast<std::size_t>(stack.Pop())];
    if (LeastDistanceSquared(box, p) > best.place.distance_squared) continue;
    if (box.left >= 0) {
      const Box& left = boxes[static_cast<std::size_t>(box.left)];
      const Box& right = boxes[static_cast<std::size_t>(box.right)];
      const bool is_left_nearer = LeastDistanceSquared(left, p) < LeastDistanceSquared(right, p);
      stack.Push(is_left_nearer ? box.right : box.left);
      stack.Push(is_left_nearer ? box.left : box.right);
      continue;
    }
    for (int k = box.begin; k < box.end; ++k) visit(k);
  }
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

SurfaceContact::SurfaceContact(SurfaceMesh surface)
    : tree_(std::make_unique<Tree>(std::move(surface))) {}

SurfaceContact::~SurfaceContact() = default;

std::optional<TouchedPlace> SurfaceContact::Find(const Vector3d& p_O, double gate) const noexcept {
  return tree_->Find(p_O, gate);
}

const SurfaceMesh& SurfaceContact::surface() const {
  return tree_->surface;
}

std::array<int, 3> NearestNodes(const SurfaceMesh& surface, const Vector3d& p_O) {
  std::vector<int> nodes;
  for (const auto& triangle : surface.triangles) {
    nodes.insert(nodes.end(), triangle.begin(), triangle.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  if (nodes.size() < 3) {
    throw std::invalid_argument("a surface of " + std::to_string(nodes.size()) +
                                " nodes: accepted are three or more");
  }
  const auto distance = [&](int node) {
    return (surface.nodes.at(static_cast<std::size_t>(node)) - p_O).squaredNorm();
  };
  std::partial_sort(nodes.begin(), nodes.begin() + 3, nodes.end(), [&](int a, int b) {
    return std::pair(distance(a), a) < std::pair(distance(b), b);
  });
  return {nodes[0], nodes[1], nodes[2]};
}

}  // namespace palpate
