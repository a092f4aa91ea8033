#include "slave/mesh/boundary_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/not_finite.h"

namespace palpate {
namespace {

// The rule of slave/solve/README.md, implemented again with arc lengths: distance along the loop in
// the shorter direction.
std::vector<int> PatchByArcLength(const BoundaryMesh& mesh, int element,
                                  const Eigen::Vector2d& place, double width) {
  std::vector<double> begin;  // arc length at which each element of the only loop begins
  double perimeter = 0;
  for (const auto& e : mesh.elements) {
    begin.push_back(perimeter);
    perimeter += e.length();
  }
  const auto own = static_cast<std::size_t>(element);
  const double centre = begin[own] + (place - mesh.elements[own].a).norm();
  std::vector<int> patch;
  for (std::size_t i = 0; i < begin.size(); ++i) {
    const double apart = std::abs(begin[i] + 0.5 * mesh.elements[i].length() - centre);
    if (std::min(apart, perimeter - apart) <= 0.5 * width * (1 + 1e-9)) {
      patch.push_back(static_cast<int>(i));
    }
  }
  if (patch.empty()) patch.push_back(element);
  return patch;
}

// Reference: slave/solve/README.md, a place on the boundary between two elements belongs to the
// larger index, also after printing the coordinate with ten digits.
TEST(FindElementTest, GivesANodeToTheLargerIndexAtEverySize) {
  for (const double size : {1e-9, 0.088, 1e3}) {
    const BoundaryMesh mesh = MeshRectangle(size, size, 60);
    for (int i = 0; i + 1 < mesh.size(); ++i) {
      const Eigen::Vector2d node = mesh.elements[static_cast<std::size_t>(i)].b;
      EXPECT_EQ(FindElement(mesh, node), i + 1) << "size " << size;
      const Eigen::Vector2d noise = Eigen::Vector2d(-1, 1) * 1e-11 * size;
      EXPECT_EQ(FindElement(mesh, node + noise), i + 1) << "size " << size;
      EXPECT_EQ(FindElement(mesh, node - noise), i + 1) << "size " << size;
    }
    EXPECT_EQ(FindElement(mesh, {0, 0}), 59);  // wraps: between 59 and 0
  }
}

TEST(PatchElementsTest, WrapsRoundItsOwnLoopOnly) {
  const std::vector<Eigen::Vector2d> outer{{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  const std::vector<Eigen::Vector2d> hole{{1, 1}, {1, 3}, {3, 3}, {3, 1}};
  const BoundaryMesh mesh = MeshPolygon({outer, {hole}}, 24);  // every element 1 long
  EXPECT_EQ(PatchElements(mesh, 0, mesh.elements[0].a, 2), (std::vector{15, 0}));
  EXPECT_EQ(PatchElements(mesh, 16, mesh.elements[16].a, 2), (std::vector{23, 16}));
  EXPECT_EQ(PatchElements(mesh, 16, mesh.elements[16].a, 100).size(), 8U);
}

// Reference: PatchByArcLength on slivers of wildly different lengths, all places and widths.
TEST(PatchElementsTest, FollowsTheRuleOnRandomSlivers) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 300; ++trial) {
    const double height = std::pow(10, -4 * uniform(random));
    const BoundaryMesh mesh = MeshRectangle(1, height, 4 + static_cast<int>(60 * uniform(random)));
    const int element = static_cast<int>(uniform(random) * mesh.size());
    const auto& e = mesh.elements[static_cast<std::size_t>(element)];
    const Eigen::Vector2d place = e.a + uniform(random) * (e.b - e.a);
    const double width = std::pow(10, 1 - 4 * uniform(random));
    std::vector<int> patch = PatchElements(mesh, element, place, width);
    std::ranges::sort(patch);
    EXPECT_EQ(patch, PatchByArcLength(mesh, element, place, width))
        << "trial " << trial << " element " << element << " width " << width;
  }
}

TEST(PatchElementsTest, IsEmptyForWhatIsNoPatch) {
  const BoundaryMesh mesh = MeshRectangle(1, 1, 40);
  EXPECT_TRUE(PatchElements(mesh, -1, {0, 0}, 0.1).empty());
  EXPECT_TRUE(PatchElements(mesh, 40, {0, 0}, 0.1).empty());
  EXPECT_TRUE(PatchElements(mesh, 0, {kNan, 0}, 0.1).empty());
  EXPECT_TRUE(PatchElements(mesh, 0, {0, 0}, kNan).empty());
  EXPECT_TRUE(PatchElements(mesh, 0, {0, 0}, -0.1).empty());
}

}  // namespace
}  // namespace palpate
