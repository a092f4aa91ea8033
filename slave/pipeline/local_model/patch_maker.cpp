#include "slave/pipeline/local_model/patch_maker.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include <Eigen/LU>

#include "shared/patch/patch_place.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMaxStiffness = 1e12;   // [N/m]
constexpr double kFreeStiffness = 1e-5;  // stiffness of a direction without resistance [N/m]
constexpr int kOwnNodes = 16;            // number of nodes next to the place

// Sets the compliance of a node of stiffness `K` in the patch's directions [m/N]; false: unknown.
bool SetNode(const Matrix3d& K, const Vector3d& n, int node, SurfacePatch* patch) {
  const double along = n.dot(K * n);
  if (!(along > kFreeStiffness) || !(along < kMaxStiffness) || !K.allFinite()) return false;
  if (patch->directions == 1) {
    patch->compliance(node, node) = static_cast<float>(1 / along);
    return true;
  }
  // A planar object has no stiffness normal to its plane.
  const Matrix3d symmetric = 0.5 * (K + K.transpose()) + kFreeStiffness * Matrix3d::Identity();
  const Matrix3d C = symmetric.inverse();
  if (!C.allFinite()) return false;
  patch->compliance.block<3, 3>(3 * node, 3 * node) = C.cast<float>();
  return true;
}

// Gives nodes with unknown compliance (at a clamped rim or never solved) the compliance of the
// nearest known node. Returns false if there is none.
bool Complete(const std::vector<char>& known, const std::vector<Vector3d>& p, SurfacePatch* patch) {
  const int n = patch->directions;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i] != 0) continue;
    std::ptrdiff_t nearest = -1;
    for (std::size_t j = 0; j < known.size(); ++j) {
      const auto index = static_cast<std::size_t>(nearest);
      const bool nearer = nearest < 0 || (p[j] - p[i]).norm() < (p[index] - p[i]).norm();
      if (known[j] != 0 && nearer) nearest = static_cast<std::ptrdiff_t>(j);
    }
    if (nearest < 0) return false;
    const int to = n * static_cast<int>(i), from = n * static_cast<int>(nearest);
    patch->compliance.block(to, to, n, n) = patch->compliance.block(from, from, n, n).eval();
  }
  MarkRim(patch);
  return true;
}

void Begin(bool frictionless, int nodes, SurfacePatch* patch) {
  patch->directions = frictionless ? 1 : 3;
  patch->node_count = nodes;
  patch->coupled = false;
  const int size = patch->directions * nodes;
  patch->compliance.setZero(size, size);
}

int AddVertex(const Vector3d& p_S, int node, SurfacePatch* patch) {
  const int vertex = patch->vertex_count++;
  patch->vertices[Index(vertex)] = p_S.cast<float>();
  patch->node_of[Index(vertex)] = static_cast<std::uint8_t>(node);
  return vertex;
}

void AddLine(int from, int to, SurfacePatch* patch) {
  patch->cells[Index(patch->cell_count++)] = {static_cast<std::uint8_t>(from),
                                              static_cast<std::uint8_t>(to), 0};
}

Vector3d InPlane(const Eigen::Vector2d& v) {
  return {v.x(), v.y(), 0};
}

// Returns the vertices used by triangles, nearest first.
std::vector<int> ByDistance(const SurfaceMesh& surface, const Vector3d& p_O) {
  std::vector<int> order;
  std::vector<char> used(surface.nodes.size(), 0);
  for (const auto& triangle : surface.triangles) {
    for (const int node : triangle) used[Index(node)] = 1;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i] != 0) order.push_back(static_cast<int>(i));
  }
  std::ranges::sort(order, {}, [&](int i) { return (surface.nodes[Index(i)] - p_O).norm(); });
  return order;
}

// The triangles whose corners lie nearest, and the vertices that they need.
struct Piece {
  std::vector<int> triangles, vertices;  // vertices, nearest first
};

Piece Around(const SurfaceMesh& surface, const Vector3d& p_O) {
  std::vector<int> order = ByDistance(surface, p_O);
  if (order.size() > kPatchVertices) order.resize(kPatchVertices);
  std::vector<int> rank(surface.nodes.size(), std::numeric_limits<int>::max());
  for (std::size_t i = 0; i < order.size(); ++i) rank[Index(order[i])] = static_cast<int>(i);
  const auto farthest = [&](int t) {
    const auto& corners = surface.triangles[Index(t)];
    return std::max({rank[Index(corners[0])], rank[Index(corners[1])], rank[Index(corners[2])]});
  };
  Piece piece;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (farthest(t) < static_cast<int>(order.size())) piece.triangles.push_back(t);
  }
  std::ranges::sort(piece.triangles, {}, farthest);
  if (piece.triangles.size() > kPatchCells) piece.triangles.resize(kPatchCells);
  const int last = piece.triangles.empty() ? -1 : farthest(piece.triangles.back());
  piece.vertices.assign(order.begin(), order.begin() + last + 1);
  return piece;
}

// Chooses the nodes among the vertices: the first few, then repeatedly the vertex farthest from all
// chosen nodes.
std::vector<int> ChooseNodes(const SurfaceMesh& surface, const std::vector<int>& vertices) {
  std::vector<int> nodes;
  std::vector<double> away(vertices.size(), std::numeric_limits<double>::infinity());
  const auto add = [&](std::size_t chosen) {
    nodes.push_back(static_cast<int>(chosen));
    const Vector3d& p = surface.nodes[Index(vertices[chosen])];
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      away[i] = std::min(away[i], (surface.nodes[Index(vertices[i])] - p).norm());
    }
  };
  for (std::size_t i = 0; i < vertices.size() && i < kOwnNodes; ++i) add(i);
  while (nodes.size() < std::min<std::size_t>(kPatchNodes, vertices.size())) {
    add(static_cast<std::size_t>(std::ranges::max_element(away) - away.begin()));
  }
  return nodes;
}

int NearestOf(const std::vector<int>& nodes, const std::vector<int>& vertices,
              const SurfaceMesh& surface, const Vector3d& p) {
  const auto away = [&](int node) {
    return (surface.nodes[Index(vertices[Index(node)])] - p).norm();
  };
  return static_cast<int>(std::ranges::min_element(nodes, {}, away) - nodes.begin());
}

Vector3d NormalOf(const SurfaceMesh& surface, int triangle) {
  const auto& [a, b, c] = surface.triangles[Index(triangle)];
  const Vector3d &pa = surface.nodes[Index(a)], &pb = surface.nodes[Index(b)],
                 &pc = surface.nodes[Index(c)];
  return (pb - pa).cross(pc - pa).stableNormalized();
}

}  // namespace

bool FillPatch(const BoundaryMesh& mesh, int element, const Isometry3d& X_SO, bool frictionless,
               const StiffnessAtPlace& stiffness, SurfacePatch* patch) {
  int loop = 1;
  for (int i = mesh.Next(element); i != element; i = mesh.Next(i)) ++loop;
  const int count = std::min(loop, kPatchNodes);
  *patch = SurfacePatch();
  patch->vertices_per_cell = 2;
  Begin(frictionless, count, patch);
  int at = element;
  for (int i = 0; i < count / 2; ++i) at = mesh.Previous(at);
  const int first = AddVertex(X_SO * InPlane(mesh.elements[Index(at)].a), 0, patch);
  int from = first;
  std::vector<char> known;
  std::vector<Vector3d> places;
  for (int node = 0; node < count; ++node, at = mesh.Next(at)) {
    const BoundaryElement& e = mesh.elements[Index(at)];
    const Vector3d n_S = X_SO.linear() * InPlane(e.normal());
    known.push_back(SetNode(stiffness(InPlane(e.midpoint()), at, n_S), n_S, node, patch) ? 1 : 0);
    places.push_back(InPlane(e.midpoint()));
    const int middle = AddVertex(X_SO * InPlane(e.midpoint()), node, patch);
    const bool closes = node + 1 == loop;
    const int to = closes ? first : AddVertex(X_SO * InPlane(e.b), node, patch);
    AddLine(from, middle, patch);
    AddLine(middle, to, patch);
    from = to;
  }
  return Complete(known, places, patch);
}

bool FillPatch(const SurfaceMesh& surface, const Vector3d& p_O, const Isometry3d& X_SO,
               bool frictionless, const StiffnessAtPlace& stiffness, SurfacePatch* patch) {
  const Piece piece = Around(surface, p_O);
  if (piece.triangles.empty()) return false;
  const std::vector<int> nodes = ChooseNodes(surface, piece.vertices);
  *patch = SurfacePatch();
  patch->vertices_per_cell = 3;
  Begin(frictionless, static_cast<int>(nodes.size()), patch);
  std::vector<int> number(surface.nodes.size(), -1);
  for (const int node : piece.vertices) {
    const Vector3d& p = surface.nodes[Index(node)];
    number[Index(node)] = AddVertex(X_SO * p, NearestOf(nodes, piece.vertices, surface, p), patch);
  }
  std::vector<char> known(nodes.size(), 0);
  std::vector<Vector3d> places;
  for (const int node : nodes) places.push_back(surface.nodes[Index(piece.vertices[Index(node)])]);
  for (const int triangle : piece.triangles) {
    auto& cell = patch->cells[Index(patch->cell_count++)];
    const Vector3d n_S = X_SO.linear() * NormalOf(surface, triangle);
    for (std::size_t k = 0; k < 3; ++k) {
      const int vertex = number[Index(surface.triangles[Index(triangle)][k])];
      cell[k] = static_cast<std::uint8_t>(vertex);
      const int node = patch->node_of[Index(vertex)];
      const bool is_node = nodes[Index(node)] == vertex;
      if (!is_node || known[Index(node)] != 0) continue;
      const Matrix3d K = stiffness(places[Index(node)], triangle, n_S);
      known[Index(node)] = SetNode(K, n_S, node, patch) ? 1 : 0;
    }
  }
  return Complete(known, places, patch);
}

}  // namespace palpate
