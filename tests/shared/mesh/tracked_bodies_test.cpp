#include "shared/mesh/tracked_bodies.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector2d;
using Loop = std::vector<Vector2d>;

Loop Square(double x, double y, double side) {
  return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}

Loop Reversed(Loop loop) {
  std::ranges::reverse(loop);
  return loop;
}

std::string RefusalOf(const std::vector<Loop>& polygons, double smallest_area = 0) {
  try {
    BodiesOf(polygons, smallest_area);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

// Reference: the rule, written out by hand. A body in the hole of a body, given in the wrong order
// and the wrong directions; every scale a scene may have.
TEST(TrackedBodies, NestedPolygonsAreBodiesAndHolesInTurn) {
  for (const double scale : {1e-9, 1.0, 1e3}) {
    std::vector<Loop> polygons{Square(4, 4, 1), Reversed(Square(0, 0, 10)), Square(3, 3, 4),
                               Square(1, 1, 1), Reversed(Square(20, 0, 2))};
    for (auto& loop : polygons) {
      for (auto& p : loop) p *= scale;
    }
    const auto bodies = BodiesOf(polygons);
    ASSERT_EQ(bodies.size(), 3U) << scale;
    EXPECT_NEAR(SignedArea(bodies[0].outer) / (scale * scale), 100, 1e-9);
    ASSERT_EQ(bodies[0].holes.size(), 2U);
    EXPECT_NEAR(SignedArea(bodies[0].holes[0]) / (scale * scale), -16, 1e-9);
    EXPECT_NEAR(SignedArea(bodies[0].holes[1]) / (scale * scale), -1, 1e-9);
    EXPECT_NEAR(SignedArea(bodies[1].outer) / (scale * scale), 4, 1e-9);
    EXPECT_NEAR(SignedArea(bodies[2].outer) / (scale * scale), 1, 1e-9);
    EXPECT_TRUE(bodies[2].holes.empty());
  }
}

// Reference: every body can be meshed, and its elements enclose its area.
TEST(TrackedBodies, ABodyThatSplitsAndMergesCanBeMeshedAtEveryStage) {
  const std::vector<std::vector<Loop>> stages{{Square(0, 0, 4)},
                                              {Square(0, 0, 4), Square(1, 1, 1)},    // a hole opens
                                              {Square(0, 0, 1.5), Square(2, 0, 2)},  // two bodies
                                              {Square(0, 0, 4)}};                    // one again
  const std::vector<std::size_t> expected{1, 1, 2, 1};
  for (std::size_t stage = 0; stage < stages.size(); ++stage) {
    const auto bodies = BodiesOf(stages[stage]);
    ASSERT_EQ(bodies.size(), expected[stage]);
    for (const auto& body : bodies) {
      const BoundaryMesh mesh = MeshPolygon(body, 40);
      double area = 0;
      for (const auto& e : mesh.elements) {
        area += 0.5 * (e.a.x() * e.b.y() - e.a.y() * e.b.x());
      }
      double outlined = SignedArea(body.outer);
      for (const auto& hole : body.holes) outlined += SignedArea(hole);
      EXPECT_NEAR(area, outlined, 1e-12);
      EXPECT_GT(area, 0);
    }
  }
}

TEST(TrackedBodies, RepeatedPointsSpecksAndThreadsAreDropped) {
  Loop closed = Square(0, 0, 4);
  closed.insert(closed.begin() + 1, closed[0]);
  closed.push_back(closed[0]);
  const Loop thread{{6, 0}, {7, 0}, {8, 0}};
  const auto bodies = BodiesOf({thread, closed, Square(1, 1, 0.1), {}, {{9, 9}}}, 0.02);
  ASSERT_EQ(bodies.size(), 1U);
  EXPECT_EQ(bodies[0].outer.size(), 4U);
  EXPECT_TRUE(bodies[0].holes.empty());
  EXPECT_EQ(BodiesOf({closed, Square(1, 1, 0.1)}).front().holes.size(), 1U);
}

TEST(TrackedBodies, RefusesWhatBoundsNoBodyAndSaysWhich) {
  EXPECT_THAT(RefusalOf({}), testing::HasSubstr("none of which bounds an area"));
  EXPECT_THAT(RefusalOf({{{0, 0}, {1, 0}}}), testing::HasSubstr("1 polygons, none"));
  EXPECT_THAT(RefusalOf({Square(0, 0, 1)}, 2), testing::HasSubstr("none of which"));
  EXPECT_THAT(RefusalOf({Square(0, 0, 4), Square(3, 3, 2)}),
              testing::HasSubstr("polygon 0 crosses or touches polygon 1"));
  EXPECT_THAT(RefusalOf({Square(0, 0, 4), {{0, 1}, {1, 1}, {1, 2}}}),
              testing::HasSubstr("crosses or touches"));
  const Loop bow{{0, 0}, {1, 1}, {1, 0}, {0, 2}};
  EXPECT_THAT(RefusalOf({Square(5, 5, 1), bow}), testing::HasSubstr("polygon 1"));
  Loop broken = Square(0, 0, 1);
  broken[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(RefusalOf({broken}), testing::HasSubstr("not finite"));
}

TEST(TrackedBodies, TheToolMeetsTheBodyItIsInOrNearest) {
  const auto bodies =
      BodiesOf({Square(0, 0, 10), Square(2, 2, 6), Square(4, 4, 2), Square(20, 0, 3)});
  ASSERT_EQ(bodies.size(), 3U);  // 10 with a hole, 3, 2 in the hole
  EXPECT_EQ(BodyUnder(bodies, {1, 1}), 0);
  EXPECT_EQ(BodyUnder(bodies, {5, 5}), 2);
  EXPECT_EQ(BodyUnder(bodies, {2.5, 5}), 0) << "in the hole, nearer to its edge";
  EXPECT_EQ(BodyUnder(bodies, {3.5, 5}), 2) << "in the hole, nearer to what lies in it";
  EXPECT_EQ(BodyUnder(bodies, {18, 1}), 1);
  EXPECT_EQ(BodyUnder(bodies, {-5, 1}), 0);
  EXPECT_EQ(BodyUnder({}, {0, 0}), -1);
  EXPECT_EQ(BodyUnder(bodies, {std::numeric_limits<double>::infinity(), 0}), -1);
}

}  // namespace
}  // namespace palpate
