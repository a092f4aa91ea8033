#include "slave/reference/planar/plane_elasticity.h"

#include <tuple>

#include <gtest/gtest.h>

namespace palpate::site {
namespace {

using Point = Eigen::Vector2d;

QuadraticMesh UnitSquare(double growth = 0.5) {
  return QuadraticMesh(MakeGradedMesh({{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                                      {{0, 1, 1}, {1, 2, 2}, {2, 3, 4}, {3, 0, 8}},
                                      {0.2, growth, {{{0.3, 1}, 1e-3}}}));
}

using Case = std::tuple<double, Plane>;

class PlaneElasticityTest : public ::testing::TestWithParam<Case> {
 protected:
  PlaneMaterial material() const { return {1, std::get<0>(GetParam()), std::get<1>(GetParam())}; }

  // Displacements `field` prescribed on the parts of the boundary named by `tags`.
  template <class Field>
  ElasticSolution Solve(const QuadraticMesh& mesh, const Field& field, int tags) const {
    const auto n = static_cast<Eigen::Index>(mesh.nodes.size());
    Prescribed prescribed = Prescribed::Constant(n, 2, false);
    Fields values = Fields::Zero(n, 2);
    for (const auto& edge : mesh.boundary) {
      if ((edge.tag & tags) == 0) continue;
      for (const int k : edge.node) {
        prescribed.row(k).setConstant(true);
        values.row(k) = field(mesh.nodes[static_cast<std::size_t>(k)]).transpose();
      }
    }
    return SolveElastic(mesh, material(), prescribed, values);
  }
};

// Reference: the patch test. A constant strain is a solution, and quadratic triangles hold it
// exactly; trace-free, so that nu = 0.5 allows it. The tolerance leaves room for the rounding of a
// mesh graded over 1:200.
TEST_P(PlaneElasticityTest, ConstantStrainIsExact) {
  const QuadraticMesh mesh = UnitSquare();
  const auto field = [](const Point& p) {
    return Point(0.1 + 0.3 * p.x() + 0.7 * p.y(), -0.2 + 0.2 * p.x() - 0.3 * p.y());
  };
  const ElasticSolution solution = Solve(mesh, field, 15);
  double worst = 0;
  for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
    const Point u = solution.displacement.row(static_cast<Eigen::Index>(k)).transpose();
    worst = std::max(worst, (u - field(mesh.nodes[k])).norm());
  }
  EXPECT_LT(worst, 1e-9);
}

// Reference: uniaxial tension of a bar that is free sideways: the pulled ends carry
// E' * strain * length with E' = E in plane stress, E / (1 - nu^2) in plane strain. Only the normal
// displacement is prescribed, and one node sideways.
TEST_P(PlaneElasticityTest, FreeBarHasTheBarsStiffness) {
  const QuadraticMesh mesh = UnitSquare();
  const auto n = static_cast<Eigen::Index>(mesh.nodes.size());
  Prescribed prescribed = Prescribed::Constant(n, 2, false);
  Fields values = Fields::Zero(n, 2);
  for (const auto& edge : mesh.boundary) {
    for (const int k : edge.node) {
      if ((edge.tag & 10) == 0) continue;
      prescribed(k, 0) = true;
      if ((edge.tag & 2) != 0) values(k, 0) = 1e-3;
      if (mesh.nodes[std::size_t(k)].norm() < 1e-12) prescribed(k, 1) = true;
    }
  }
  const ElasticSolution solution = SolveElastic(mesh, material(), prescribed, values);
  double pull = 0;
  for (Eigen::Index k = 0; k < n; ++k) pull += values(k, 0) > 0 ? solution.reaction(k, 0) : 0;
  const double nu = material().nu;
  const double modulus = material().plane == Plane::kStress ? 1 : 1 / (1 - nu * nu);
  EXPECT_NEAR(pull / (1e-3 * modulus), 1, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Materials, PlaneElasticityTest,
                         ::testing::Combine(::testing::Values(-0.3, 0.0, 0.3, 0.41, 0.499, 0.5),
                                            ::testing::Values(Plane::kStress, Plane::kStrain)));

}  // namespace
}  // namespace palpate::site
