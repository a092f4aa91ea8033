#include "slave/reference/membrane/membrane_face.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace palpate::simulation {
namespace {

using Eigen::Vector2d;

class MembraneFaceTest : public testing::TestWithParam<Vector2d> {
 protected:
  static constexpr double kRadius = 0.039;
  DiscMesh mesh_{{1, 0.05, GetParam().norm() / kRadius}, 0.025, {1, 7, 6, 1}};
  MembraneFace face_{mesh_, GetParam(), kRadius};
};

// Reference: the area of the polygon on the rim's nodes; no triangle overlaps, since all are
// positive.
TEST_P(MembraneFaceTest, TrianglesCoverThePlate) {
  const auto nodes = face_.Nodes();
  double area = 0;
  for (const auto& [a, b, c] : face_.Triangles()) {
    const auto at = [&](int i) { return nodes[static_cast<std::size_t>(i)]; };
    const Vector2d ab = at(b) - at(a), ac = at(c) - at(a);
    const double twice = ab.x() * ac.y() - ab.y() * ac.x();
    EXPECT_GT(twice, 0);
    area += 0.5 * twice;
  }
  const int sides = 3 * 6 * (mesh_.is_quarter() ? 4 : 2);
  const double polygon = 0.5 * sides * std::sin(2 * std::numbers::pi / sides);
  EXPECT_NEAR(area / (kRadius * kRadius), polygon, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(CentreAndBeside, MembraneFaceTest,
                         testing::Values(Vector2d(0, 0), Vector2d(-0.01, 0.017)));

}  // namespace
}  // namespace palpate::simulation
