#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "slave/mesh/outline.h"

namespace palpate {
namespace {

// Returns the number of elements on each side of a rectangle, by their outward normal.
std::array<int, 4> SideCounts(const BoundaryMesh& mesh) {
  std::array<int, 4> counts{};  // bottom, right, top, left
  for (const auto& element : mesh.elements) {
    const Eigen::Vector2d n = element.normal();
    ++counts[n.y() < -0.5 ? 0 : n.x() > 0.5 ? 1 : n.y() > 0.5 ? 2 : 3];
  }
  return counts;
}

// Every element starts where the previous one of its loop ends, to the last bit.
void ExpectClosed(const BoundaryMesh& mesh) {
  for (int i = 0; i < mesh.size(); ++i) {
    const auto next = static_cast<std::size_t>(mesh.Next(i));
    EXPECT_EQ(mesh.elements[static_cast<std::size_t>(i)].b, mesh.elements[next].a)
        << "element " << i;
    EXPECT_EQ(mesh.Previous(mesh.Next(i)), i);
  }
}

// Enclosed area by the divergence theorem: sum of midpoint . normal length / 2.
double EnclosedArea(const BoundaryMesh& mesh) {
  double area = 0;
  for (const auto& e : mesh.elements) area += 0.5 * e.midpoint().dot(e.normal()) * e.length();
  return area;
}

// Law: elements of equal length divide each side in proportion to its length.
TEST(MeshRectangleTest, SharesElementsByLength) {
  const auto counts = [](double w, double h, int n) { return SideCounts(MeshRectangle(w, h, n)); };
  EXPECT_EQ(counts(0.088, 0.088, 60), (std::array{15, 15, 15, 15}));
  EXPECT_EQ(counts(0.088, 0.088, 540), (std::array{135, 135, 135, 135}));
  EXPECT_EQ(counts(0.2, 0.1, 60), (std::array{20, 10, 20, 10}));
  EXPECT_EQ(counts(0.3, 0.1, 8), (std::array{3, 1, 3, 1}));
  EXPECT_EQ(counts(1.0, 1.0, 4), (std::array{1, 1, 1, 1}));
  EXPECT_EQ(counts(1000.0, 0.001, 100), (std::array{49, 1, 49, 1}));
}

TEST(MeshRectangleTest, RefusesWhatIsNoRectangle) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, nan, infinity}) {
    EXPECT_THROW(MeshRectangle(bad, 1, 60), std::invalid_argument) << bad;
    EXPECT_THROW(MeshRectangle(1, bad, 60), std::invalid_argument) << bad;
    EXPECT_THROW(MeshDisc(bad, 60), std::invalid_argument) << bad;
  }
  EXPECT_THROW(MeshRectangle(1, 1, 3), std::invalid_argument);
  EXPECT_THROW(MeshDisc(1, 2), std::invalid_argument);
  EXPECT_THROW(MeshPolygon({{{0, 0}, {1, 0}, {0, 1}}, {}}, 2), std::invalid_argument);
}

// Definition: inscribed regular polygon, first vertex at -pi/N, element 0 at angle 0.
// Area N/2 R^2 sin(2 pi / N). Tolerance: rounding of N terms.
TEST(MeshDiscTest, IsTheInscribedRegularPolygonTurnedByHalfAnElement) {
  for (const int count : {3, 60, 61, 4000}) {
    const BoundaryMesh mesh = MeshDisc(0.6e-3, count);
    ExpectClosed(mesh);
    EXPECT_EQ(mesh.length_unit, 0.6e-3);
    const auto& first = mesh.elements[0];
    EXPECT_NEAR(std::atan2(first.a.y(), first.a.x()), -std::numbers::pi / count, 1e-15);
    EXPECT_NEAR(first.midpoint().y(), 0, 1e-18);
    EXPECT_GT(first.midpoint().x(), 0);
    const double area = 0.5 * count * 0.36e-6 * std::sin(2 * std::numbers::pi / count);
    EXPECT_NEAR(EnclosedArea(mesh) / area, 1.0, 1e-12) << count;
  }
}

TEST(MeshPolygonTest, TurnsAClockwiseOuterLoopAndCounterClockwiseHoles) {
  const std::vector<Eigen::Vector2d> clockwise{{0, 0}, {0, 4}, {4, 4}, {4, 0}};
  const std::vector<Eigen::Vector2d> hole{{1, 1}, {3, 1}, {3, 3}, {1, 3}};
  const BoundaryMesh mesh = MeshPolygon({clockwise, {hole}}, 48);
  ExpectClosed(mesh);
  EXPECT_EQ(mesh.loop_begin, (std::vector{0, 32, 48}));
  EXPECT_EQ(mesh.elements[0].a, Eigen::Vector2d(0, 0));
  // Area of the body: both loops together, holes counting against it.
  EXPECT_NEAR(EnclosedArea(mesh), 16 - 4, 1e-12);
}

}  // namespace
}  // namespace palpate
