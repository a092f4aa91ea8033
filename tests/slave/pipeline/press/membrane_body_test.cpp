#include "slave/pipeline/press/membrane_body.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slave/mechanics/membrane/inflated_membrane.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

constexpr double kBodyRadius = 0.05;

InflatedMembrane TestMembrane() {
  Ellipsoid sphere;
  sphere.semi_axes *= kBodyRadius;
  return {MeshDomedMembrane(sphere, {0, 0, 1}, 0.01, 10),
          {.modulus = 1400, .tension = 320, .air_stiffness = 3e8}};
}

class MembraneBodyTest : public ::testing::Test {
 protected:
  // Returns the nodes, displaced by an even pressure of total `force` around `node`.
  std::vector<SurfacePoint> Points(int node, double force) {
    const PatchCompliance patch(membrane_, 0.014);
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < membrane_.surface().nodes.size(); ++i) {
      SurfacePoint point;
      point.id = static_cast<int>(i);
      point.seen = true;
      point.p_S_rest = membrane_.surface().nodes[i];
      point.p_S = point.p_S_rest +
                  force * patch.by_patch()(static_cast<int>(i), node) * membrane_.normals()[i];
      point.covariance = 1e-10 * Eigen::Matrix3d::Identity();
      points.push_back(point);
    }
    return points;
  }
  InflatedMembrane membrane_ = TestMembrane();
  MembraneBody body_{TestMembrane(), 0.014};
};

// Reference: the applied force, Newton's third law between load and nodes, and the observed
// displacement.
TEST_F(MembraneBodyTest, TheLoadIsFoundAndItsFieldIsTheOneSeen) {
  const int node = 60;
  const auto points = Points(node, 2);
  const SurfaceLoad load = body_.Fit(points);
  EXPECT_EQ(load.validity, Validity::kValid) << load.reason;
  EXPECT_NEAR(load.force, -2, 0.01);
  EXPECT_LT((load.p_O - membrane_.surface().nodes[node]).norm(), 0.3e-3);
  EXPECT_LT(load.residual, 1);
  std::vector<Eigen::Vector3d> forces;
  body_.NodalForces(&forces);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& f : forces) sum += f;
  EXPECT_NEAR(sum.dot(load.n_O), load.force, 0.01);
  std::vector<Eigen::Vector3d> u;
  body_.Displacements(&u);
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Eigen::Vector3d& n = membrane_.normals()[i];
    EXPECT_NEAR(n.dot(u[i]), n.dot(points[i].p_S - points[i].p_S_rest), 0.02e-3) << i;
  }
}

// Reference: the compliance is symmetric. A press at a node moves another node as much as a press
// there moves this one.
TEST_F(MembraneBodyTest, APressTakesTheForceThatMakesItsDepth) {
  const SurfaceLoad load = body_.Fit(Points(60, 2));
  const auto press = body_.PressAt(load.p_O, load.depth);
  ASSERT_TRUE(press.valid);
  EXPECT_NEAR(press.force, 2, 0.01);
  EXPECT_NEAR(press.stiffness, press.force / load.depth, 1e-9 * press.stiffness);
  EXPECT_EQ(body_.PressAt(load.p_O, -1e-3).force, 0);
  EXPECT_FALSE(body_.PressAt(load.p_O, std::nan("")).valid);
  EXPECT_FALSE(body_.PressAt(membrane_.surface().nodes.back(), 1e-3).valid);
}

TEST_F(MembraneBodyTest, FittingAllocatesNothingForThePointsItKnows) {
  const auto points = Points(60, 2);
  body_.Fit(points);
  const long before = AllocationCount();
  for (int k = 0; k < 5; ++k) {
    body_.Fit(points);
    body_.PressAt({0, 0, kBodyRadius}, 1e-3);
  }
  EXPECT_EQ(AllocationCount(), before);
}

}  // namespace
}  // namespace palpate
