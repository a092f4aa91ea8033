// Bodies that several tests press on.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "slave/mechanics/bem/bem2d_model.h"
#include "tests/slave/mechanics/contacts.h"

namespace palpate::bodies {

using contacts::Respond;

inline constexpr std::array kOrders{ElementOrder::kConstant, ElementOrder::kLinear,
                                    ElementOrder::kQuadratic};

inline ReferenceProblem Block(int elements, double side = 1, double nu = 0.45,
                              Plane plane = Plane::kStrain) {
  ReferenceProblem problem{MeshRectangle(side, side, elements), {}, nu, plane};
  for (const auto& e : problem.mesh.elements) {
    const bool bottom = e.midpoint().y() < 1e-6 * side;
    problem.held.push_back({bottom, bottom});
  }
  return problem;
}

// Returns the problem of the body without supports.
inline ReferenceProblem Free(const BoundaryMesh& mesh, double nu, Plane plane) {
  return {mesh, std::vector<std::array<bool, 2>>(mesh.elements.size(), {false, false}), nu, plane};
}

// Between the circles of radius a (clockwise) and b, `count` elements each.
inline BoundaryMesh Ring(double a, double b, int count) {
  BoundaryMesh mesh;
  mesh.length_unit = 2 * b;
  const auto corner = [&](double radius, int i) {
    const double angle = std::numbers::pi / count * (2 * i - 1);
    return Eigen::Vector2d(radius * std::cos(angle), radius * std::sin(angle));
  };
  for (int i = 0; i < count; ++i) mesh.elements.push_back({corner(b, i), corner(b, i + 1)});
  for (int i = 0; i < count; ++i) mesh.elements.push_back({corner(a, 1 - i), corner(a, -i)});
  mesh.loop_begin = {0, count, 2 * count};
  return mesh;
}

inline Contact At(int element, Contact::Kind kind, const Eigen::Vector2d& value) {
  Contact contact;
  contact.kind = kind;
  contact.element = element;
  contact.prescribed_O.head<2>() = value;
  return contact;
}

inline Contact Move(int element, const Eigen::Vector2d& displacement) {
  return At(element, Contact::Kind::kDisplacement, displacement);
}

inline Contact Load(int element, const Eigen::Vector2d& force) {
  return At(element, Contact::Kind::kForce, force);
}

inline BoundaryState Boundary(Bem2dModel& model, const std::vector<Contact>& contacts) {
  Solution solution;
  model.Solve(contacts, &solution);
  return model.Boundary(solution);
}

// A uniform pressure on every element of the last loop.
inline std::vector<Contact> PressureOnLastLoop(const BoundaryMesh& mesh, double pressure,
                                               double thickness) {
  std::vector<Contact> loads;
  for (int i = mesh.loop_begin[mesh.loop_begin.size() - 2]; i < mesh.size(); ++i) {
    const auto& e = mesh.elements[static_cast<std::size_t>(i)];
    loads.push_back(Load(i, -pressure * thickness * e.length() * e.normal()));
  }
  return loads;
}

}  // namespace palpate::bodies
