// Bodies, supports and contacts shared by the tests of solids.
#pragma once

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mesh/index.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/support/fixed_nodes.h"
#include "tests/support/references.h"

namespace palpate::solid_tests {

using contacts::Answer;
using contacts::Move;
using contacts::Push;
using reference::json;
using reference::VectorOf;

inline HeldNodes Bottom(const SolidMesh& mesh) {
  return FixedWhere(mesh, [](const Eigen::Vector3d& p) { return p.z() == 0; });
}

inline HeldNodes Nothing(const SolidMesh& mesh) {
  return HeldNodes(mesh.nodes.size(), {false, false, false});
}

inline Eigen::Matrix3d Random(std::mt19937* engine, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return Eigen::Matrix3d::NullaryExpr([&] { return uniform(*engine); });
}

inline const std::vector<OgdenTerm> kRubber{{0.7, 1.3}, {0.2, 5}, {0.1, -2}};

inline int NodeAt(const SolidModel& model, double unit, const Eigen::Vector3d& p_O) {
  for (int i = 0; i < model.mesh().node_count(); ++i) {
    if ((unit * model.mesh().nodes[Index(i)] - p_O).norm() < 1e-9 * unit) {
      return i;
    }
  }
  ADD_FAILURE() << "no node at " << p_O.transpose();
  return 0;
}

using Element = FemOptions::Element;
using Law = FemOptions::Law;

// The foam cube of the references: 6 cm, 3.8 kPa, nu 0.15, 45 kg/m^3, its bottom held.
constexpr double kCube = 0.06;
inline SolidModel::Params Foam(Element element, Law law) {
  return {.options = {.element = element, .law = law},
          .young_modulus = 3800,
          .poisson_ratio = 0.15,
          .density = 45,
          .range = 1};
}

// A uniform pressure on the triangles of the top whose centroid lies in the central square, with
// `force` in total. It uses one contact per triangle, because the reference's load is no disc.
inline std::vector<Contact> SquareLoad(const SolidMesh& mesh, double force) {
  const SurfaceMesh surface = SurfaceOf(mesh);
  std::vector<Contact> contacts;
  double area = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const Eigen::Vector3d centroid = Centroid(surface, t);
    const auto inside = [](double x) { return x > kCube / 3 && x < 2 * kCube / 3; };
    const bool top = centroid.z() > kCube * (1 - 1e-9);
    if (!top || !inside(centroid.x()) || !inside(centroid.y())) continue;
    const double A = Area(surface, t);
    area += A;
    Contact contact = Push(centroid, {0, 0, -A}, 1e-9 * kCube);  // the one triangle there
    contact.element = t;
    contacts.push_back(contact);
  }
  for (auto& contact : contacts) contact.prescribed_O *= force / area;
  return contacts;
}

}  // namespace palpate::solid_tests
