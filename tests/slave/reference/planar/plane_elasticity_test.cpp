#include "slave/reference/planar/plane_elasticity.h"

#include <gtest/gtest.h>

namespace palpate::simulation {
namespace {

using Point = Eigen::Vector2d;

// Reference: the patch test. A constant strain, prescribed on the boundary, is a solution, and
// quadratic triangles represent it exactly. It is trace-free, so that nu = 0.5 is possible.
// Tolerance: rounding on a mesh graded over 1:200.
TEST(PlaneElasticity, ConstantStrainIsExact) {
  const QuadraticMesh mesh(MakeGradedMesh({{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                                          {{0, 1, 1}, {1, 2, 2}, {2, 3, 4}, {3, 0, 8}},
                                          {0.2, 0.5, {{{0.3, 1}, 1e-3}}}));
  const auto n = static_cast<Eigen::Index>(mesh.nodes.size());
  Fields exact(n, 2);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Point& p = mesh.nodes[static_cast<std::size_t>(k)];
    exact.row(k) << 0.1 + 0.3 * p.x() + 0.7 * p.y(), -0.2 + 0.2 * p.x() - 0.3 * p.y();
  }
  Prescribed prescribed = Prescribed::Constant(n, 2, false);
  Fields values = Fields::Zero(n, 2);
  for (const auto& edge : mesh.boundary) {
    for (const int k : edge.node) {
      prescribed.row(k).setConstant(true);
      values.row(k) = exact.row(k);
    }
  }
  for (const double nu : {-0.3, 0.0, 0.3, 0.41, 0.499, 0.5}) {
    for (const Plane plane : {Plane::kStress, Plane::kStrain}) {
      const ElasticSolution solution = SolveElastic(mesh, {1, nu, plane}, prescribed, values);
      EXPECT_LT((solution.displacement - exact).rowwise().norm().maxCoeff(), 1e-9)
          << nu << (plane == Plane::kStress ? ", stress" : ", strain");
    }
  }
}

}  // namespace
}  // namespace palpate::simulation
