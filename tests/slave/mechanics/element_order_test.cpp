// Compares linear and quadratic elements with exact solutions: fields that each order represents
// exactly, and the order of convergence for others.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mesh/index.h"
#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Displacement, and stress over E.
struct Exact {
  std::function<Vector2d(const Vector2d&)> displacement;
  std::function<Matrix2d(const Vector2d&)> stress;
};

struct PlaneMaterial {
  double nu;
  Plane plane;
  [[nodiscard]] double shear_modulus() const { return 1 / (2 * (1 + nu)); }
  [[nodiscard]] double plane_modulus() const {
    return plane == Plane::kStrain ? 1 / (1 - nu * nu) : 1;
  }
  [[nodiscard]] double plane_nu() const { return plane == Plane::kStrain ? nu / (1 - nu) : nu; }
};

// u = H p with a constant stress; at nu = 0.5 H is traceless, and a pressure without displacement
// is added.
Exact Uniform(const PlaneMaterial& material, const Matrix2d& stress) {
  const double E = material.plane_modulus(), nu = material.plane_nu();
  const Matrix2d strain = ((1 + nu) * stress - nu * stress.trace() * Matrix2d::Identity()) / E;
  return {[=](const Vector2d& p) -> Vector2d {
            return strain * p + Vector2d(0.1 - 0.3 * p.y(), 0.2 + 0.3 * p.x());
          },
          [=](const Vector2d&) { return stress; }};
}

// s_xx = y: pure bending.
Exact BendingField(const PlaneMaterial& material) {
  const double E = material.plane_modulus(), nu = material.plane_nu();
  return {[=](const Vector2d& p) -> Vector2d {
            return Vector2d(p.x() * p.y(), -0.5 * (p.x() * p.x() + nu * p.y() * p.y())) / E;
          },
          [](const Vector2d& p) { return (Matrix2d() << p.y(), 0, 0, 0).finished(); }};
}

// u = grad f with f harmonic keeps every volume and solves Navier's equations for any nu; the
// stress is 2 G grad grad f. Here f = exp(2 x) cos(2 y) / 4.
Exact HarmonicField(const PlaneMaterial& material) {
  const double G = material.shear_modulus();
  return {[](const Vector2d& p) -> Vector2d {
            return 0.5 * std::exp(2 * p.x()) * Vector2d(std::cos(2 * p.y()), -std::sin(2 * p.y()));
          },
          [=](const Vector2d& p) -> Matrix2d {
            const double c = std::cos(2 * p.y()), s = std::sin(2 * p.y());
            return 2 * G * std::exp(2 * p.x()) * (Matrix2d() << c, -s, -s, -c).finished();
          }};
}

// The displacement of f = ln r about `centre`: a source in a hole. The plain equations lose this
// field at nu = 0.5.
Exact Source(const PlaneMaterial& material, const Vector2d& centre) {
  const double G = material.shear_modulus();
  return {[=](const Vector2d& p) -> Vector2d { return (p - centre) / (p - centre).squaredNorm(); },
          [=](const Vector2d& p) -> Matrix2d {
            const Vector2d r = p - centre;
            const double r2 = r.squaredNorm();
            return 2 * G * (Matrix2d::Identity() / r2 - 2 * r * r.transpose() / (r2 * r2));
          }};
}

Exact Sum(const Exact& one, const Exact& other) {
  return {
      [=](const Vector2d& p) -> Vector2d { return one.displacement(p) + other.displacement(p); },
      [=](const Vector2d& p) -> Matrix2d { return one.stress(p) + other.stress(p); }};
}

ReferenceProblem HeldOnTheLeft(const BoundaryMesh& mesh, const PlaneMaterial& material,
                               ElementOrder order) {
  ReferenceProblem problem = bodies::Free(mesh, material.nu, material.plane);
  problem.order = order;
  for (int i = 0; i < mesh.loop_begin[1]; ++i) {
    const bool left = mesh.elements[Index(i)].normal().x() < -0.9;
    problem.held[Index(i)] = {left, left};
  }
  return problem;
}

struct Errors {
  double displacement = 0, traction = 0;  // largest, over the largest
};

// Prescribes the exact displacement at the supported nodes and the exact traction at all others,
// and compares the computed values.
Errors ErrorsOf(const ReferenceProblem& problem, const Exact& exact) {
  const GreensFunctions greens(problem);
  const double unit = problem.mesh.length_unit;
  const auto traction = [&](int i) -> Vector2d {
    const auto element = Index(greens.node(i).element);
    return exact.stress(greens.node(i).p_O) * problem.mesh.elements[element].normal();
  };
  Errors errors;
  double largest_u = 0, largest_t = 0;
  for (int i = 0; i < greens.size(); ++i) {
    Vector2d answer = Vector2d::Zero();
    for (int j = 0; j < greens.size(); ++j) {
      const Vector2d given =
          greens.held(j, 0) ? Vector2d(exact.displacement(greens.node(j).p_O) / unit) : traction(j);
      answer += Eigen::Map<const Matrix2d>(greens.block(i, j)) * given;
    }
    const Vector2d u = exact.displacement(greens.node(i).p_O) / unit;
    largest_u = std::max(largest_u, u.norm());
    largest_t = std::max(largest_t, traction(i).norm());
    if (greens.held(i, 0)) {
      errors.traction = std::max(errors.traction, (answer - traction(i)).norm());
    } else {
      errors.displacement = std::max(errors.displacement, (answer - u).norm());
    }
  }
  return {errors.displacement / largest_u, errors.traction / std::max(largest_t, 1e-3)};
}

BoundaryMesh Rectangle(int count) {
  return MeshRectangle(2, 1, count);
}

// A slanted body with a square and a triangular hole.
BoundaryMesh Perforated(int count) {
  return MeshPolygon(
      {{{0, 0}, {4, 0}, {5, 3}, {0, 3}},
       {{{0.6, 0.6}, {1.8, 0.6}, {1.8, 1.8}, {0.6, 1.8}}, {{2.6, 1.2}, {3.8, 1.2}, {3.2, 2.4}}}},
      count);
}

const std::array<PlaneMaterial, 5> kMaterials{
    PlaneMaterial{0.3, Plane::kStress}, PlaneMaterial{0.5, Plane::kStress},
    PlaneMaterial{-0.9, Plane::kStrain}, PlaneMaterial{0.3, Plane::kStrain},
    PlaneMaterial{0.5, Plane::kStrain}};

std::string NameOfMaterial(const PlaneMaterial& m) {
  return (m.plane == Plane::kStress ? "plane stress, nu " : "plane strain, nu ") +
         std::to_string(m.nu);
}

// Reference: exact uniform stresses with a rigid motion, and pure bending, which quadratic elements
// represent, too. Tolerance: double precision with integration errors and a condition of 1e3 to
// 1e5.
TEST(ElementOrder, ElementsPassThePatchTestsOfTheirOrder) {
  const auto expect_exact = [](const PlaneMaterial& material, ElementOrder order,
                               const Exact& exact, const std::string& field) {
    for (const auto& mesh : {Rectangle(12), Perforated(22)}) {
      const Errors errors = ErrorsOf(HeldOnTheLeft(mesh, material, order), exact);
      EXPECT_LT(errors.displacement, 1e-9) << NameOfMaterial(material) << ", " << field;
      EXPECT_LT(errors.traction, 1e-9) << NameOfMaterial(material) << ", " << field;
    }
  };
  const std::array<std::pair<const char*, Vector3d>, 5> stresses{{{"xx", {1, 0, 0}},
                                                                  {"yy", {0, 1, 0}},
                                                                  {"xy", {0, 0, 1}},
                                                                  {"pressure", {1, 1, 0}},
                                                                  {"rigid", {0, 0, 0}}}};
  for (const auto& material : kMaterials) {
    for (const auto& [field, s] : stresses) {
      const Exact exact = Uniform(material, (Matrix2d() << s[0], s[2], s[2], s[1]).finished());
      for (const ElementOrder order : {ElementOrder::kLinear, ElementOrder::kQuadratic}) {
        expect_exact(material, order, exact, field);
      }
    }
    expect_exact(material, ElementOrder::kQuadratic, BendingField(material), "bending");
  }
}

// The order of the error between the last two numbers of elements.
double LastOrder(const std::vector<int>& counts, const std::function<double(int)>& error_of) {
  double previous = 0, order = 0;
  int previous_count = 0;
  for (const int count : counts) {
    const double error = std::abs(error_of(count));
    if (previous_count > 0) {
      order = std::log(previous / error) / std::log(static_cast<double>(count) / previous_count);
    }
    previous = error;
    previous_count = count;
  }
  return order;
}

constexpr std::array<const char*, 3> kNames{"constant", "linear", "quadratic"};
std::string Title(ElementOrder order, const PlaneMaterial& material) {
  return std::string(kNames[static_cast<std::size_t>(order)]) + ", " + NameOfMaterial(material);
}

// Reference: an exact solution that no order represents exactly, on a body with corners, held and
// free sides. The order of convergence is at least one more than the degree of the polynomials. The
// nodes are points of superconvergence, except at the ends of the support.
TEST(ElementOrder, SmoothFieldsConvergeWithTheTextbooksOrder) {
  for (const auto& material : {kMaterials[0], kMaterials[3], kMaterials[4]}) {
    for (const ElementOrder order : bodies::kOrders) {
      const double measured = LastOrder({24, 48, 96}, [&](int count) {
        return ErrorsOf(HeldOnTheLeft(Rectangle(count), material, order), HarmonicField(material))
            .displacement;
      });
      EXPECT_GT(measured, static_cast<int>(order) + 1 - 0.25) << Title(order, material);
    }
  }
}

// Reference: sources in both holes, whose fields become inaccurate as 1 - 2 nu approaches zero.
TEST(ElementOrder, BodiesWithHolesConvergeUpToNuOneHalf) {
  for (const double nu : {0.3, 0.4999, 0.5}) {
    const PlaneMaterial material{nu, Plane::kStrain};
    const Exact exact = Sum(Source(material, {1.3, 1.1}), Source(material, {3.2, 1.5}));
    const std::vector<int> counts = nu == 0.5 ? std::vector{66, 132, 264} : std::vector{66, 132};
    for (const ElementOrder order : bodies::kOrders) {
      const double measured = LastOrder(counts, [&](int count) {
        return ErrorsOf(HeldOnTheLeft(Perforated(count), material, order), exact).displacement;
      });
      EXPECT_GT(measured, static_cast<int>(order) + 1 - 0.3) << Title(order, material);
    }
  }
}

// Reference: uniform tension of a square without supports, u = p / E (x, -nu y) from its centre.
// Linear and quadratic elements represent this linear field exactly. Constant elements have an
// error of a few percent, and in a corner an additional one from the half element between corner
// and midpoint. Inside, where the corners have no influence, the same elements in NumPy have an
// error of 0.3 %.
TEST(ElementOrder, VerticesAndPlacesInsideMoveAsUniformTensionSays) {
  const double side = 0.1, nu = 0.3, E = 1e5, thickness = 0.01, pull = 100;
  for (const ElementOrder order : bodies::kOrders) {
    ReferenceProblem problem = bodies::Free(MeshRectangle(side, side, 60), nu, Plane::kStress);
    problem.order = order;
    const BoundaryMesh mesh = problem.mesh;
    Bem2dModel model(problem, {.young_modulus = E, .thickness = thickness});
    std::vector<Contact> contacts;
    for (int i = 0; i < mesh.size(); ++i) {
      const auto& element = mesh.elements[Index(i)];
      // Share of the area that faces x [m^2].
      const double share = (element.b - element.a).y() * thickness;
      if (std::abs(share) > 1e-9) contacts.push_back(bodies::Load(i, {pull * share, 0}));
    }
    Solution solution;
    ASSERT_EQ(bodies::Respond(model, contacts, &solution).front().validity, Validity::kValid);
    std::vector<Vector2d> places;
    for (const Vector3d& p_O : model.field_mesh().vertices) places.emplace_back(p_O.head<2>());
    const std::size_t vertices = places.size();
    const std::vector<Vector2d>& inside = model.cover().inside;
    places.insert(places.end(), inside.begin(), inside.end());
    std::vector<Vector3d> u, on_outline;
    model.CoverDisplacements(solution, &u);
    model.Displacements(solution, &on_outline);
    ASSERT_EQ(u.size(), places.size());
    ASSERT_GT(inside.size(), 100U);
    EXPECT_TRUE(std::equal(on_outline.begin(), on_outline.end(), u.begin()));
    for (std::size_t i = 0; i < u.size(); ++i) {
      const double of_constant = i < vertices ? 0.1 : 0.005;
      const double tolerance = order == ElementOrder::kConstant ? of_constant : 1e-9;
      const Vector2d p = places[i] - Vector2d(side, side) / 2;
      const Vector2d expected = pull / E * Vector2d(p.x(), -nu * p.y());
      EXPECT_LT((u[i].head<2>() - expected).norm(), tolerance * pull / E * side / 2) << i;
    }
  }
}

}  // namespace
}  // namespace palpate
