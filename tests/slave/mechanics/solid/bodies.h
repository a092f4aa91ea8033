// Bodies, holds and contacts that the tests of solids share.
#pragma once

#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/support/fixed_nodes.h"
#include "tests/support/references.h"

namespace palpate::solid_tests {

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

inline int NodeAt(const SolidModel& model, double unit, const Eigen::Vector3d& p_O) {
  for (int i = 0; i < model.mesh().node_count(); ++i) {
    if ((unit * model.mesh().nodes[static_cast<std::size_t>(i)] - p_O).norm() < 1e-9 * unit) {
      return i;
    }
  }
  ADD_FAILURE() << "no node at " << p_O.transpose();
  return 0;
}

using Element = FemOptions::Element;
using Law = FemOptions::Law;
using Time = FemOptions::Time;

// The foam cube of the references: 6 cm, 3.8 kPa, nu 0.15, 45 kg/m^3, its bottom held.
constexpr double kCube = 0.06;
inline SolidModel::Params Foam(Element element, Law law) {
  SolidModel::Params params;
  params.options.element = element;
  params.options.law = law;
  params.young_modulus = 3800;
  params.poisson_ratio = 0.15;
  params.density = 45;
  params.range = 1;
  return params;
}

// A uniform pressure on the triangles of the top whose centroid lies in the middle square, `force`
// in all, as one contact per triangle: the reference's load is no disc.
inline std::vector<Contact> SquareLoad(const SolidMesh& mesh, double force) {
  const SurfaceMesh surface = SurfaceOf(mesh);
  std::vector<Contact> contacts;
  double area = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
    double lowest = kCube;
    for (const int node : surface.triangles[static_cast<std::size_t>(t)]) {
      centroid += surface.nodes[static_cast<std::size_t>(node)] / 3;
      lowest = std::min(lowest, surface.nodes[static_cast<std::size_t>(node)].z());
    }
    const auto inside = [](double x) { return x > kCube / 3 && x < 2 * kCube / 3; };
    if (lowest < kCube * (1 - 1e-9) || !inside(centroid.x()) || !inside(centroid.y())) continue;
    const auto& [a, b, c] = surface.triangles[static_cast<std::size_t>(t)];
    const Eigen::Vector3d ab =
        surface.nodes[static_cast<std::size_t>(b)] - surface.nodes[static_cast<std::size_t>(a)];
    const Eigen::Vector3d ac =
        surface.nodes[static_cast<std::size_t>(c)] - surface.nodes[static_cast<std::size_t>(a)];
    const double A =
        0.5 * Eigen::Vector3d(ab.y() * ac.z() - ab.z() * ac.y(), ab.z() * ac.x() - ab.x() * ac.z(),
                              ab.x() * ac.y() - ab.y() * ac.x())
                  .norm();
    area += A;
    Contact contact = Push(centroid, {0, 0, -A}, 1e-9 * kCube);  // the one triangle there
    contact.element = t;
    contacts.push_back(contact);
  }
  for (auto& contact : contacts) contact.prescribed_O *= force / area;
  return contacts;
}

}  // namespace palpate::solid_tests
