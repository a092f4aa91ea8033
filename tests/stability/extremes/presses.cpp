#include "tests/stability/extremes/presses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/fem/fem_model.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mesh/index.h"
#include "slave/solve/case_solver.h"

namespace palpate::extremes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Position in -1 to 1 of an even one, denser around 0.
double Graded(double t) {
  constexpr double kStep = 0.4;  // slope at 0
  return kStep * t + (1 - kStep) * std::pow(t, 5);
}

// From the square of side 2 to the unit disc; nearly the identity around the origin.
Vector2d OnDisc(const Vector2d& p) {
  const double side = p.cwiseAbs().maxCoeff(), r = p.norm();
  return r > 0 ? Vector2d(p * (1 + side * side * (side / r - 1))) : p;
}

double Fall(double r) {
  return kCapRadius - std::sqrt(kCapRadius * kCapRadius - r * r);
}

// Smallest dihedral angle of a tetrahedron [degrees]; negative: its volume is.
double Dihedral(const SolidMesh& mesh, int tet) {
  if (!(SignedVolume(mesh, tet) > 0)) return -1;
  const auto& nodes = mesh.tets[Index(tet)];
  std::array<Vector3d, 4> normals;  // of the face opposite to each corner, inward
  for (int k = 0; k < 4; ++k) {
    const auto at = [&](int c) { return mesh.nodes[Index(nodes[Index((k + c) % 4)])]; };
    const Vector3d n = (at(2) - at(1)).cross(at(3) - at(1));
    normals[Index(k)] = n.normalized() * (n.dot(at(0) - at(1)) > 0 ? 1 : -1);
  }
  double smallest = 180;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < i; ++k) {
      const double cosine = -normals[Index(i)].dot(normals[Index(k)]);
      smallest = std::min(smallest, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
  }
  return smallest * 180 / std::numbers::pi;
}

// Moves a node towards the opposite face of one of its tetrahedra until that is a sliver. False:
// another one would turn over.
bool MakeSliver(int node, const std::vector<int>& around, SolidMesh* mesh) {
  const Vector3d rest = mesh->nodes[Index(node)];
  Vector3d face = Vector3d::Zero();
  for (const int corner : mesh->tets[Index(around.front())]) {
    if (corner != node) face += mesh->nodes[Index(corner)] / 3;
  }
  const auto smallest = [&](double part) {
    mesh->nodes[Index(node)] = rest + part * (face - rest);
    double least = 180;
    for (const int tet : around) least = std::min(least, Dihedral(*mesh, tet));
    return least;
  };
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (smallest(middle) > kSliver ? low : high) = middle;
  }
  if (std::abs(smallest(low) - kSliver) < 1e-6) return true;
  mesh->nodes[Index(node)] = rest;
  return false;
}

// Slivers below the tool: nodes without a tetrahedron in common, inside the body.
void AddSlivers(SolidMesh* mesh) {
  std::vector<std::vector<int>> around(mesh->nodes.size());
  for (std::size_t t = 0; t < mesh->tets.size(); ++t) {
    for (const int node : mesh->tets[t]) around[Index(node)].push_back(static_cast<int>(t));
  }
  std::vector<char> is_taken(mesh->nodes.size(), 0);
  for (const auto& triangle : SurfaceOf(*mesh).triangles) {
    for (const int node : triangle) is_taken[Index(node)] = 1;
  }
  for (std::size_t i = 0; i < mesh->nodes.size(); ++i) {
    const Vector3d& p = mesh->nodes[i];
    const bool is_below = std::hypot(p.x(), p.y()) < 2 * kFaceRadius && p.z() > kBodyHeight / 2;
    if (!is_below || is_taken[i] != 0) continue;
    if (!MakeSliver(static_cast<int>(i), around[i], mesh)) continue;
    for (const int tet : around[i]) {
      for (const int node : mesh->tets[Index(tet)]) is_taken[Index(node)] = 1;
    }
  }
}

// The tool in the units of the scene; of a prism it reaches through the thickness.
Tool ToolOf(const ToolPressed& pressed, bool is_planar) {
  Tool tool;
  if (pressed.is_round) {
    tool.shape = Tool::Shape::kRound;
    tool.radius = kBallRadius * pressed.unit;
    tool.width = 2 * kBodyRadius * pressed.unit;
  } else {
    tool.width = 2 * kFaceRadius * pressed.unit;
  }
  if (is_planar) tool.depth = std::numeric_limits<double>::infinity();
  return tool;
}

Scene SceneOf(const Family& family, const ToolPressed& pressed) {
  Scene scene;
  scene.name = family.name;
  scene.object.material = {.young_modulus = pressed.E, .poisson_ratio = pressed.nu};
  scene.model.kind = family.kind;
  if (family.set) family.set(&scene.model);
  scene.model.contact = pressed.friction == 0          ? ContactLaw::kFrictionless
                        : std::isinf(pressed.friction) ? ContactLaw::kBonded
                                                       : ContactLaw::kFriction;
  if (scene.model.contact == ContactLaw::kFriction) scene.model.friction = pressed.friction;
  scene.model.range = 0.1;
  return scene;
}

void RequireFinite(const ContactResponse& r) {
  const bool is_finite = r.force_O.allFinite() && r.displacement_O.allFinite() &&
                         r.stiffness_O.allFinite() && (!r.moment_O || r.moment_O->allFinite()) &&
                         std::isfinite(r.force_error) && std::isfinite(r.moment_sigma);
  if (!is_finite) throw std::runtime_error("a number is not finite");
}

}  // namespace

std::string ToolPressed::text() const {
  return Formatted("%s, %s, %g mm deep, nu %g, friction %g, unit %g m, %g Pa%s",
                   is_cap ? "cap" : "cylinder", is_round ? "round" : "flat", depth, nu, friction,
                   unit, E, has_slivers ? ", slivers" : "");
}

bool TakesFriction(const Family& family, double friction) {
  if (std::isinf(friction)) return true;
  ModelOptions model;
  model.kind = family.kind;
  if (family.set) family.set(&model);
  const ModelKind* kind = FindModelKind(family.kind);
  return FollowsTools(model) || (friction == 0 && kind->accepts_frictionless && !kind->iterates);
}

SolidMesh PressedBody(const ToolPressed& pressed) {
  SolidMesh mesh = MeshBox({2, 2, 1}, {pressed.cells, pressed.cells, pressed.cells / 2});
  for (Vector3d& p : mesh.nodes) {
    const Vector2d at = kBodyRadius * OnDisc({Graded(p.x() - 1), Graded(p.y() - 1)});
    const double top = kBodyHeight - (pressed.is_cap ? Fall(at.norm()) : 0);
    p = {at.x(), at.y(), top * (1 - Graded(1 - p.z()))};
  }
  if (pressed.has_slivers) AddSlivers(&mesh);
  for (Vector3d& p : mesh.nodes) p *= pressed.unit;
  return mesh;
}

double SmallestDihedral(const SolidMesh& mesh) {
  double smallest = 180;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    smallest = std::min(smallest, Dihedral(mesh, static_cast<int>(t)));
  }
  return smallest;
}

Scene PressScene(const Family& family, const ToolPressed& pressed) {
  Scene scene = SceneOf(family, pressed);
  scene.object.geometry = MeshFileGeometry{};
  scene.object.fixed = {Fixed{FixedPlane{2, 0}, {true, true, true}}};
  scene.tool = ToolOf(pressed, false);
  return scene;
}

Scene PrismScene(const Family& family, const ToolPressed& pressed, double thickness) {
  Scene scene = SceneOf(family, pressed);
  scene.object.geometry = RectangleGeometry{2 * kBodyRadius * pressed.unit,
                                            kBodyHeight * pressed.unit, thickness * pressed.unit};
  scene.object.fixed = {Fixed{FixedSide{"bottom"}, {true, true, true}}};
  scene.tool = ToolOf(pressed, true);
  return scene;
}

Pressed PressOnce(const Scene& scene, const ObjectMesh& mesh, const Vector3d& p_O,
                  const Vector3d& depth_O, double unit) {
  const auto model = MakeModel(scene, mesh);
  const RowRules rules = RulesOf(scene);
  const auto refuse = [](std::string_view column, const std::string& accepted) {
    throw std::invalid_argument(std::string(column) + ": expected " + accepted);
  };
  std::vector<SolveRow> rows{
      RowReader(mesh, rules)
          .Read({.p_O = p_O, .prescribed_O = depth_O}, Contact::Kind::kDisplacement, refuse)};
  CaseSolver solver(scene, mesh, model.get());
  Solution solution;
  Pressed pressed;
  const bool is_solved = solver.Solve({0}, CaseStart::kRest, &rows, &solution);
  if (const auto* fem = dynamic_cast<const FemModel*>(model.get())) {
    pressed.newton_steps = fem->newton_steps();
    pressed.iterations = fem->iterations();
  } else if (const auto* solid = dynamic_cast<const SolidModel*>(model.get())) {
    pressed.newton_steps = solid->newton_steps();
  }
  const ContactResponse& response = rows.front().response;
  RequireFinite(response);
  if (!is_solved || response.validity == Validity::kFailed) {
    if (solver.failure().empty()) throw std::runtime_error("failed without a reason");
    throw std::invalid_argument(std::string(solver.failure()));
  }
  const double newtons = scene.object.material.young_modulus * unit * unit;
  pressed.validity = response.validity;
  pressed.flag_reason = response.flag_reason;
  const double force = response.force_O.norm();
  const double along = depth_O.norm() > 0 ? response.force_O.dot(depth_O.normalized()) : force;
  pressed.force = along / newtons;
  pressed.error = force > 0 ? response.force_error / force : 0;
  return pressed;
}

Pressed PressOnTop(const Family& family, const ToolPressed& pressed) {
  const double u = pressed.unit;
  return PressOnce(PressScene(family, pressed), PressedBody(pressed), {0, 0, kBodyHeight * u},
                   {0, 0, -pressed.depth * u}, u);
}

Pressed PressPrism(const Family& family, const ToolPressed& pressed, double thickness) {
  const double u = pressed.unit;
  const Scene scene = PrismScene(family, pressed, thickness);
  return PressOnce(scene, MeshObject(scene, std::nullopt), {kBodyRadius * u, kBodyHeight * u, 0},
                   {0, -pressed.depth * u, 0}, u);
}

}  // namespace palpate::extremes
