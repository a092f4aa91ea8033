// A slab on a rigid base and a disc that presses it, as zones and as the full model see it.
#pragma once

#include <vector>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/fem/zone/zone_set.h"
#include "slave/mesh/index.h"
#include "tests/support/fixed_nodes.h"

namespace palpate::zone_tests {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kModulus = 5000;  // [Pa]

struct Slab {
  SolidMesh mesh;
  HeldNodes held;
  double nu = 0;
  std::vector<Vector3d> positions;  // in units of length

  // 80 x 80 x 40 mm in cells of 80 mm / `cells`.
  Slab(int cells, double poisson_ratio)
      : mesh(MeshBox({0.08, 0.08, 0.04}, {cells, cells, cells / 2})), nu(poisson_ratio) {
    held = FixedWhere(mesh, [](const Vector3d& p) { return p.z() == 0; });
    for (const Vector3d& p : mesh.nodes) positions.push_back(p / LargerSide(mesh.nodes));
  }
  [[nodiscard]] SolidModel Full(FemOptions::Law law) const {
    SolidParams params;
    params.options.law = law;
    params.options.residual = 1e-9;
    params.young_modulus = kModulus;
    params.poisson_ratio = nu;
    params.density = 1000;
    return {mesh, held, params};
  }
  [[nodiscard]] double force_unit() const {
    return kModulus * LargerSide(mesh.nodes) * LargerSide(mesh.nodes);
  }
};

inline std::vector<int> NodesUnder(const SolidMesh& mesh, const Vector3d& p_O, double width) {
  const SurfaceMesh surface = SurfaceOf(mesh);
  return PatchAt(surface, *FindPlace(surface, p_O), p_O, width).nodes;
}

// A disc that moves its nodes, in a zone of `radius` [m].
inline ZoneSet::Touch PressedDisc(const Slab& slab, const Vector3d& p_O, double width,
                                  double radius) {
  ZoneSet::Touch touch;
  touch.centre_O = p_O;
  touch.radius = radius;
  touch.nodes = NodesUnder(slab.mesh, p_O, width);
  for (int k = 0; k < static_cast<int>(touch.nodes.size()); ++k) {
    touch.contact.points.push_back({{k, 1.0}});
  }
  return touch;
}

// The same for every contact node, in units of length.
inline VectorXd Alike(const Slab& slab, const ZoneContact& contact, const Vector3d& displacement) {
  const auto points = static_cast<int>(contact.points.size());
  return (displacement / LargerSide(slab.mesh.nodes)).replicate(points, 1);
}

}  // namespace palpate::zone_tests
