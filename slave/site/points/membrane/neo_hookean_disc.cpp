#include "slave/site/points/membrane/neo_hookean_disc.h"

#include <vector>

#include "shared/geometry/index.h"

namespace palpate::site {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

static_assert(DiscMesh::kAcross == DiscMesh::kThrough);

PlacedElement ElementOf(const DiscMesh& mesh, int ring, int ray, int layer) {
  static const ElementShape cube = ElementShape::Cube(3, DiscMesh::kAcross);
  std::vector<int> nodes;
  MatrixXd places(3, cube.nodes());
  for (const int column : mesh.element(ring, ray)) {
    for (int i = 0; i <= DiscMesh::kThrough; ++i) {
      const int level = DiscMesh::kThrough * layer + i;
      places.col(static_cast<Eigen::Index>(nodes.size())) << mesh.place(column),
          mesh.thickness() * level / (mesh.levels() - 1);
      nodes.push_back(mesh.levels() * column + level);
    }
  }
  return {cube, places, std::move(nodes)};
}

std::vector<PlacedElement> ElementsOf(const DiscMesh& mesh) {
  std::vector<PlacedElement> elements;
  for (int ring = 0; ring < mesh.rings(); ++ring) {
    for (int ray = 0; ray < mesh.rays(); ++ray) {
      for (int layer = 0; layer < mesh.layers(); ++layer) {
        elements.push_back(ElementOf(mesh, ring, ray, layer));
      }
    }
  }
  return elements;
}

}  // namespace

NeoHookeanDisc::NeoHookeanDisc(const DiscMesh& mesh, double nu, double tension)
    : mesh_(mesh),
      body_(ElementsOf(mesh), mesh.levels() * mesh.free_columns(), NeoHookean(nu, tension)) {
  free_.setOnes(size());
  for (int circle = 0; circle + 1 < mesh.circle_lines(); ++circle) {
    for (int ray = 0; ray < mesh.ray_lines(); ++ray) {
      const auto held = mesh.Held(circle, ray);
      for (int i = 0; i < 3 * mesh.levels(); ++i) {
        if (held[Index(i % 3)]) free_[unknown(mesh.column(circle, ray), i / 3, i % 3)] = 0;
      }
    }
  }
}

VectorXd NeoHookeanDisc::ToolLoad() const {
  static const ElementShape face = ElementShape::Cube(2, DiscMesh::kAcross);
  VectorXd load = VectorXd::Zero(size());
  MatrixXd places(2, face.nodes());
  for (int ring = 0; ring < mesh_.inner_rings(); ++ring) {
    for (int ray = 0; ray < mesh_.rays(); ++ray) {
      const auto columns = mesh_.element(ring, ray);
      for (int i = 0; i < face.nodes(); ++i) places.col(i) = mesh_.place(columns[Index(i)]);
      const VectorXd shares = face.values * PlacedElement(face, places, {}).weights;
      for (int i = 0; i < face.nodes(); ++i) {
        load[unknown(columns[Index(i)], mesh_.levels() - 1, 2)] -= shares[i];
      }
    }
  }
  return load / (-load.sum() * (mesh_.is_quarter() ? 4 : 2));
}

bool NeoHookeanDisc::Forces(const VectorXd& u, VectorXd* forces) const {
  if (!body_.Forces(u, forces)) return false;
  *forces = forces->cwiseProduct(free_);
  return true;
}

bool NeoHookeanDisc::Linearise(const VectorXd& u, VectorXd* forces, Matrix* stiffness) const {
  if (!body_.Linearise(u, forces, stiffness)) return false;
  *forces = forces->cwiseProduct(free_);
  NeoHookeanBody::Hold(free_, stiffness);
  return true;
}

}  // namespace palpate::site
