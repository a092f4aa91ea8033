#include "slave/mechanics/fem/solid/element_mesh.h"

#include <Eigen/Geometry>

#include "shared/geometry/index.h"
#include "shared/mesh/node_merger.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kFlat = 1e-14;  // volume / longest edge^3 of what counts as none

void AddFaces(ElementMesh* mesh, EdgeMiddles* middle) {
  mesh->touch_surface.nodes = mesh->nodes;
  for (const auto& [a, b, c] : mesh->surface.triangles) {
    if (mesh->nodes_per_element == 4) {
      mesh->faces.push_back({a, b, c, -1, -1, -1});
      mesh->touch_surface.triangles.push_back({a, b, c});
      continue;
    }
    const int ab = (*middle)(a, b), bc = (*middle)(b, c), ca = (*middle)(c, a);
    mesh->faces.push_back({a, b, c, ab, bc, ca});
    for (const std::array<int, 3>& t :
         {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) {
      mesh->touch_surface.triangles.push_back(t);
    }
  }
}

}  // namespace

ElementMesh MakeElementMesh(const SolidMesh& mesh, FemOptions::Element element, double unit) {
  RequireReadable(mesh);
  RequireVolumes(mesh, kFlat);
  ElementMesh made;
  made.vertex_count = static_cast<int>(mesh.nodes.size());
  made.nodes_per_element = element == FemOptions::Element::kTet10 ? 10 : 4;
  for (const auto& p : mesh.nodes) made.nodes.emplace_back(p / unit);
  EdgeMiddles middle(&made.nodes);
  for (const auto& tet : mesh.tets) {
    made.connectivity.insert(made.connectivity.end(), tet.begin(), tet.end());
    if (made.nodes_per_element == 4) continue;
    for (const auto& [a, b] : kTetEdges)
      made.connectivity.push_back(middle(tet[Index(a)], tet[Index(b)]));
  }
  made.modulus = mesh.modulus;
  made.surface.triangles = SurfaceOf(mesh).triangles;
  made.surface.nodes.assign(made.nodes.begin(), made.nodes.begin() + made.vertex_count);
  AddFaces(&made, &middle);
  return made;
}

TetGeometry GeometryOf(const ElementMesh& mesh, int element) {
  const auto nodes = mesh.element(element);
  const auto p = [&](std::size_t i) -> const Vector3d& { return mesh.nodes[Index(nodes[i])]; };
  const Vector3d a = p(1) - p(0), b = p(2) - p(0), c = p(3) - p(0);
  const double six_volumes = a.dot(b.cross(c));
  TetGeometry geometry;
  geometry.volume = six_volumes / 6;
  geometry.grad.col(1) = b.cross(c) / six_volumes;
  geometry.grad.col(2) = c.cross(a) / six_volumes;
  geometry.grad.col(3) = a.cross(b) / six_volumes;
  geometry.grad.col(0) = -(geometry.grad.col(1) + geometry.grad.col(2) + geometry.grad.col(3));
  return geometry;
}

std::span<const QuadraturePoint> QuadratureOf(int nodes_per_element) {
  static const std::array<QuadraturePoint, 1> kCentre{{{Vector4d::Constant(0.25), 1}}};
  constexpr double kNear = 0.58541019662496845446, kFar = 0.13819660112501051518;
  static const std::array<QuadraturePoint, 4> kFour{{{Vector4d(kNear, kFar, kFar, kFar), 0.25},
                                                     {Vector4d(kFar, kNear, kFar, kFar), 0.25},
                                                     {Vector4d(kFar, kFar, kNear, kFar), 0.25},
                                                     {Vector4d(kFar, kFar, kFar, kNear), 0.25}}};
  if (nodes_per_element == 4) return kCentre;
  return kFour;
}

ShapeValues ShapesAt(int nodes_per_element, const Vector4d& bary) {
  if (nodes_per_element == 4) return bary;
  ShapeValues shapes(10);
  for (int i = 0; i < 4; ++i) shapes[i] = bary[i] * (2 * bary[i] - 1);
  for (int e = 0; e < 6; ++e) {
    const auto [a, b] = kTetEdges[Index(e)];
    shapes[4 + e] = 4 * bary[a] * bary[b];
  }
  return shapes;
}

ShapeValues ShapeIntegrals(int nodes_per_element) {
  if (nodes_per_element == 4) return ShapeValues::Constant(4, 0.25);
  ShapeValues integrals(10);
  integrals << Vector4d::Constant(-1.0 / 20), Eigen::Matrix<double, 6, 1>::Constant(1.0 / 5);
  return integrals;
}

Eigen::MatrixXd ShapeProducts(int nodes_per_element) {
  if (nodes_per_element == 4) return (Eigen::Matrix4d::Ones() + Eigen::Matrix4d::Identity()) / 20;
  Eigen::MatrixXd products(10, 10);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) products(i, j) = i == j ? 6 : 1;
    for (int e = 0; e < 6; ++e) {
      const auto [a, b] = kTetEdges[Index(e)];
      products(i, 4 + e) = products(4 + e, i) = i == a || i == b ? -4 : -6;
    }
  }
  for (int e = 0; e < 6; ++e) {
    for (int f = 0; f < 6; ++f) {
      const auto [a, b] = kTetEdges[Index(e)];
      const auto [c, d] = kTetEdges[Index(f)];
      const int shared = (a == c || a == d) + (b == c || b == d);
      products(4 + e, 4 + f) = shared == 2 ? 32 : shared == 1 ? 16 : 8;
    }
  }
  return products / 420;
}

}  // namespace palpate
