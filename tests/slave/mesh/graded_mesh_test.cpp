#include "slave/mesh/graded_mesh.h"

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Point = Eigen::Vector2d;

struct Domain {
  const char* name;
  std::vector<std::vector<Point>> loops;
};

std::vector<Point> Circle(Point centre, double radius, int count) {
  std::vector<Point> loop;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    loop.push_back(centre + radius * Point(std::cos(angle), std::sin(angle)));
  }
  return loop;
}

struct Input {
  std::vector<Point> points;
  std::vector<MeshSegment> segments;
};

// Makes a segment of every edge of the loops, with the edge's number as tag.
Input SegmentsOf(const Domain& domain) {
  Input input;
  for (const auto& loop : domain.loops) {
    const int begin = static_cast<int>(input.points.size()), n = static_cast<int>(loop.size());
    for (int i = 0; i < n; ++i) {
      input.points.push_back(loop[static_cast<std::size_t>(i)]);
      input.segments.push_back({begin + i, begin + (i + 1) % n, begin + i});
    }
  }
  return input;
}

double ShoelaceArea(const std::vector<Point>& loop) {
  double twice = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Point &a = loop[i], &b = loop[(i + 1) % loop.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

double SmallestAngle(const TriangleMesh& mesh) {
  double smallest = 4;
  for (const auto& v : mesh.triangles) {
    const auto at = [&](std::size_t i) { return mesh.points[std::size_t(v[i % 3])]; };
    for (std::size_t i = 0; i < 3; ++i) {
      const Point a = at(i + 1) - at(i), b = at(i + 2) - at(i);
      smallest = std::min(smallest, std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
    }
  }
  return smallest;
}

class GradedMeshTest : public ::testing::TestWithParam<Domain> {
 protected:
  TriangleMesh Make() const {
    const Input input = SegmentsOf(GetParam());
    return MakeGradedMesh(input.points, input.segments,
                          {0.15, 0.4, {{input.points[0], 1e-5}, {input.points[1], 1e-4}}});
  }
};

// Reference: the shoelace formula on the loops themselves.
TEST_P(GradedMeshTest, TrianglesFillTheOutline) {
  double area = 0;
  for (const auto& loop : GetParam().loops) area += ShoelaceArea(loop);
  EXPECT_NEAR(Area(Make()), area, 1e-12);
}

// Reference: Ruppert's bound asin(1 / (2 B)) = 21.7 degrees for the ratio B = 1.35 in use; all
// corners here are 60 degrees or wider.
TEST_P(GradedMeshTest, NoAngleIsBelowTwentyDegrees) {
  EXPECT_GT(SmallestAngle(Make()), 20 * std::numbers::pi / 180);
}

INSTANTIATE_TEST_SUITE_P(
    Domains, GradedMeshTest,
    ::testing::Values(Domain{"Square", {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}}},
                      Domain{"Disc", {Circle({0.5, 0.5}, 0.5, 360)}},
                      Domain{"SquareWithHole",
                             {{{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                              [] {
                                auto hole = Circle({0.6, 0.4}, 0.2, 40);
                                std::reverse(hole.begin(), hole.end());
                                return hole;
                              }()}},
                      Domain{"LShape", {{{0, 0}, {1, 0}, {1, 0.5}, {0.5, 0.5}, {0.5, 1}, {0, 1}}}},
                      Domain{"Sliver", {{{0, 0}, {1, 0}, {1, 0.01}, {0, 0.01}}}},
                      Domain{"ShortEdge",
                             {{{0, 0}, {0.5, 0}, {0.5 + 1e-7, 0}, {1, 0}, {1, 1}, {0, 1}}}}),
    [](const auto& domain) { return std::string(domain.param.name); });

// Ruppert's algorithm need not terminate at a corner of 5 degrees; the minimum length must end it.
TEST(GradedMesh, EndsInASharpCorner) {
  const Input input =
      SegmentsOf({"", {{{0, 0}, {1, 0}, {1, std::tan(5 * std::numbers::pi / 180)}}}});
  const TriangleMesh mesh = MakeGradedMesh(input.points, input.segments, {0.1, 0.4, {}});
  EXPECT_NEAR(Area(mesh), 0.5 * std::tan(5 * std::numbers::pi / 180), 1e-12);
  EXPECT_LT(mesh.triangles.size(), 3000u);
}

}  // namespace
}  // namespace palpate
