#include "slave/mesh/planar_cover.h"

#include <algorithm>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "slave/mesh/graded_mesh.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

struct Body {
  const char* name;
  Outline outline;
  double area;  // computed from rectangles, without the code under test [m^2]
};

class PlanarCoverTest : public ::testing::TestWithParam<Body> {};

// Reference: the body's area. Its edges are straight, so that triangles which cover exactly the
// body have this area; the tolerance is rounding.
TEST_P(PlanarCoverTest, CoversTheBodyAndNothingElse) {
  const BoundaryMesh mesh = MeshPolygon(GetParam().outline, 90);
  const PlanarCover cover = CoverOf(mesh, 300);
  std::vector<Vector2d> points;
  for (const BoundaryElement& e : mesh.elements) points.push_back(e.a);
  points.insert(points.end(), cover.inside.begin(), cover.inside.end());
  double area = 0;
  std::set<int> used;
  for (const auto& [a, b, c] : cover.triangles) {
    const double twice = Orientation(points[Index(a)], points[Index(b)], points[Index(c)]);
    EXPECT_GT(twice, 0);
    area += twice / 2;
    used.insert({a, b, c});
  }
  EXPECT_NEAR(area / GetParam().area, 1, 1e-9);
  EXPECT_EQ(used.size(), points.size());
  EXPECT_GT(cover.inside.size(), 100U);
  EXPECT_LT(cover.inside.size(), 400U);
}

// Nearer to an element than it is long, constant elements show their steps.
TEST_P(PlanarCoverTest, PlacesKeepTheLengthOfAnElementFromIt) {
  const BoundaryMesh mesh = MeshPolygon(GetParam().outline, 90);
  for (const Vector2d& p : CoverOf(mesh, 300).inside) {
    EXPECT_TRUE(Contains(GetParam().outline, p));
    for (const BoundaryElement& e : mesh.elements) {
      EXPECT_GE((p - e.midpoint()).norm(), e.length());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Bodies, PlanarCoverTest,
    ::testing::Values(
        Body{"Square", {{{0, 0}, {0.1, 0}, {0.1, 0.1}, {0, 0.1}}, {}}, 0.01},
        Body{"AngleOfAMicrometre",
             {{{0, 0}, {2e-6, 0}, {2e-6, 1e-6}, {1e-6, 1e-6}, {1e-6, 2e-6}, {0, 2e-6}}, {}},
             3e-12},
        Body{"Frame", {{{0, 0}, {5, 0}, {5, 5}, {0, 5}}, {{{2, 2}, {3, 2}, {3, 3}, {2, 3}}}}, 24}),
    [](const auto& info) { return std::string(info.param.name); });

// With elements as long as the body's height there are no points inside; the outline's points alone
// must cover it.
TEST(PlanarCoverTest, ALongAndThinBodyIsCoveredByItsOutline) {
  const PlanarCover cover = CoverOf(MeshRectangle(1, 0.01, 100), 300);
  EXPECT_TRUE(cover.inside.empty());
  EXPECT_EQ(cover.triangles.size(), 98U);
}

}  // namespace
}  // namespace palpate
