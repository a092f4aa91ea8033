#include <limits>
#include <optional>
#include <random>
#include <stdexcept>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "slave/contact/boundary_contact.h"
#include "slave/mesh/boundary_patch.h"
#include "tests/slave/contact/random_outline.h"

namespace palpate {
namespace {

Eigen::Vector2d RandomPoint(std::mt19937* random, double reach) {
  std::uniform_real_distribution<double> coordinate(-reach, reach);
  const double x = coordinate(*random);
  return {x, coordinate(*random)};
}

// Fraction of the path at which it first crosses any element from its outer side, by solving
// from + t path = a + s (b - a) for every element.
std::optional<double> FirstEntryByForce(const BoundaryMesh& mesh, const Eigen::Vector2d& from,
                                        const Eigen::Vector2d& to) {
  std::optional<double> first;
  for (const auto& e : mesh.elements) {
    Eigen::Matrix2d system;
    system << (to - from), (e.a - e.b);
    const Eigen::Vector2d ts = system.inverse() * (e.a - from);
    const bool crosses = ts.x() >= 0 && ts.x() < 1 && ts.y() >= 0 && ts.y() <= 1;
    if (crosses && (to - from).dot(e.normal()) < 0 && (!first || ts.x() < *first)) first = ts.x();
  }
  return first;
}

// Reference: all elements, one by one. Tolerance: the intersection is computed in two ways; its
// condition 1 / sin(angle between path and element) stays below 1e4 for this seed.
TEST(ObbTreeTest, FindsTheFirstEntryThatTryingEveryElementFinds) {
  std::mt19937 random(1);
  int entries = 0;
  for (int body = 0; body < 60; ++body) {
    const Outline outline = RandomOutline(&random);
    const BoundaryMesh mesh = MeshPolygon(outline, 3 + static_cast<int>(random() % 400));
    const ObbTree tree(mesh);
    for (int i = 0; i < 300; ++i) {
      const Eigen::Vector2d from = RandomPoint(&random, 1.5);
      const Eigen::Vector2d to = i % 2 == 0 ? RandomPoint(&random, 1.5)
                                            : Eigen::Vector2d(from + RandomPoint(&random, 0.1));
      if (Contains(outline, from)) continue;
      const auto entry = tree.FirstEntry(from, to);
      const auto expected = FirstEntryByForce(mesh, from, to);
      ASSERT_EQ(entry.has_value(), expected.has_value()) << "body " << body << " path " << i;
      if (!entry) continue;
      ++entries;
      const Eigen::Vector2d p = from + *expected * (to - from);
      EXPECT_LT((entry->p_O - p).norm(), 1e-11) << "body " << body << " path " << i;
    }
  }
  EXPECT_GT(entries, 3000);  // there are enough entries for the comparison
}

// Reference: the smallest distance over all elements, as in FindElement. The result is equal, since
// the projection is the same.
TEST(ObbTreeTest, FindsTheNearestPlaceFromAnyStart) {
  std::mt19937 random(2);
  for (int body = 0; body < 60; ++body) {
    const BoundaryMesh mesh =
        MeshPolygon(RandomOutline(&random), 3 + static_cast<int>(random() % 400));
    const ObbTree tree(mesh);
    for (int i = 0; i < 300; ++i) {
      const Eigen::Vector2d p = RandomPoint(&random, i % 3 == 0 ? 100 : 1.5);
      const int near = static_cast<int>(random() % mesh.elements.size());
      double least = std::numeric_limits<double>::infinity();
      for (const auto& e : mesh.elements) least = std::min(least, DistanceTo(e, p));
      EXPECT_DOUBLE_EQ((tree.Nearest(p, near).p_O - p).norm(), least) << "body " << body;
      EXPECT_EQ(tree.Nearest(p, near).p_O, tree.Nearest(p).p_O);
    }
  }
}

// The side of the nearest place is the side of the body, at corners of every kind.
TEST(ObbTreeTest, DistinguishesInsideFromOutside) {
  std::mt19937 random(3);
  for (int body = 0; body < 60; ++body) {
    const Outline outline = RandomOutline(&random);
    const ObbTree tree(MeshPolygon(outline, 100));
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d p = RandomPoint(&random, 1.2);
      const bool is_inside = tree.HeightOver(tree.Nearest(p).element, p) < 0;
      EXPECT_EQ(is_inside, Contains(outline, p)) << "body " << body << " at " << p.transpose();
    }
  }
}

TEST(ObbTreeTest, LetsNoPathThroughBetweenTwoElements) {
  // Paths from outside to every node of a disc along many directions: a gap of one rounding error
  // would let some of the paths in.
  const BoundaryMesh mesh = MeshDisc(0.3, 97);
  const ObbTree tree(mesh);
  for (const auto& e : mesh.elements) {
    for (double angle = -1.2; angle <= 1.2; angle += 0.13) {
      const Eigen::Vector2d direction = Eigen::Rotation2D<double>(angle) * e.a.normalized();
      const auto entry = tree.FirstEntry(e.a + 0.7 * direction, e.a - 0.1 * direction);
      ASSERT_TRUE(entry.has_value()) << e.a.transpose() << " from " << angle;
      EXPECT_LT((entry->p_O - e.a).norm(), 1e-15);
    }
  }
}

TEST(ObbTreeTest, APathThatOnlyTouchesDoesNotEnter) {
  const ObbTree square(MeshRectangle(1, 1, 40));
  EXPECT_FALSE(square.FirstEntry({-1, 0}, {1, -2}));          // passes by
  EXPECT_FALSE(square.FirstEntry({-0.5, 0.5}, {0.5, -0.5}));  // through the corner (0, 0), outside
  EXPECT_FALSE(square.FirstEntry({0.5, -0.5}, {-0.5, 0.5}));  // and back
  EXPECT_FALSE(square.FirstEntry({-1, 1}, {2, 1}));           // along the top
  EXPECT_FALSE(square.FirstEntry({2, 1}, {-1, 1}));
  EXPECT_FALSE(square.FirstEntry({0.5, 2}, {0.5, 1}));  // ends on it
  EXPECT_FALSE(square.FirstEntry({0.5, 1}, {0.5, 2}));  // leaves the square
  EXPECT_FALSE(square.FirstEntry({0.5, 2}, {0.5, 2}));  // does not move
}

// Elements of 1 and 1e-6: boxes must not swallow the short ones.
TEST(ObbTreeTest, HandlesElementsOfWildlyDifferentLength) {
  const BoundaryMesh mesh =
      MeshPolygon({{{0, 0}, {1, 0}, {1, 1}, {0.500001, 1}, {0.5, 1}, {0, 1}}, {}}, 6);
  const ObbTree tree(mesh);
  const auto entry = tree.FirstEntry({0.5000005, 2}, {0.5000005, 0.5});
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->element, 3);
  EXPECT_EQ(tree.Nearest({0.5000004, 1.1}).element, 3);
  EXPECT_EQ(tree.Nearest({0.7, 1.1}).element, 2);
}

TEST(ObbTreeTest, RefusesWhatIsNoBoundary) {
  EXPECT_THROW(ObbTree{BoundaryMesh{}}, std::invalid_argument);
  BoundaryMesh mesh = MeshRectangle(1, 1, 4);
  mesh.elements[2].b = mesh.elements[2].a;
  EXPECT_THROW(ObbTree{mesh}, std::invalid_argument);
  mesh.elements[2].b.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ObbTree{mesh}, std::invalid_argument);
}

}  // namespace
}  // namespace palpate
