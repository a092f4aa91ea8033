#include "slave/mesh/outline.h"

#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/not_finite.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;
using Loop = std::vector<Eigen::Vector2d>;

Loop Square(double x, double y, double side) {
  return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}

// A 1 mm square 1 km from the origin: summing x y products there would lose 1e-10 of 1e-6.
TEST(SignedAreaTest, DoesNotSufferFarFromTheOrigin) {
  EXPECT_NEAR(SignedArea(Square(1000, 1000, 1e-3)) / 1e-6, 1.0, 1e-9);
}

TEST(ContainsTest, IsInsideTheOuterLoopAndOutsideTheHoles) {
  const Outline frame{Square(0, 0, 10), {Square(3, 3, 4)}};
  EXPECT_TRUE(Contains(frame, {1, 1}));
  EXPECT_FALSE(Contains(frame, {5, 5}));
  EXPECT_FALSE(Contains(frame, {-1, 5}));
  EXPECT_FALSE(Contains(frame, {11, 3}));
}

struct BadOutline {
  const char* name;
  Outline outline;
  const char* message;
};

class CheckOutlineTest : public ::testing::TestWithParam<BadOutline> {};

// The result must not depend on the size: the same shape at 1 nm, 1 m and 1 km.
TEST_P(CheckOutlineTest, SaysWhatIsWrongAtEverySize) {
  for (const double scale : {1e-9, 1.0, 1e3}) {
    Outline outline = GetParam().outline;
    for (auto& p : outline.outer) p *= scale;
    for (auto& hole : outline.holes) {
      for (auto& p : hole) p *= scale;
    }
    EXPECT_THAT(Thrown<std::invalid_argument>([&] { CheckOutline(outline); }),
                HasSubstr(GetParam().message))
        << "at scale " << scale;
    EXPECT_THROW(MeshPolygon(outline, 60), std::invalid_argument);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Outlines, CheckOutlineTest,
    ::testing::Values(
        BadOutline{"Empty", {}, "0 points: expected three or more"},
        BadOutline{"NaN", {{{0, 0}, {1, 0}, {1, kNan}}, {}}, "point 2 is not finite"},
        BadOutline{"OnePlace", {{{1, 1}, {1, 1}, {1, 1}}, {}}, "all points coincide"},
        BadOutline{"Repeated", {{{0, 0}, {1, 0}, {1, 0}, {0, 1}}, {}}, "points 1 and 2"},
        BadOutline{"NoArea", {{{0, 0}, {1, 0}, {2, 0}}, {}}, "encloses no area"},
        BadOutline{"Bow", {{{0, 0}, {2, 2}, {2, 0}, {0, 1}}, {}}, "edges 0 and 2 cross or touch"},
        BadOutline{"Spike", {{{0, 0}, {2, 0}, {1, 0}, {1, 1}}, {}}, "folds back"},
        BadOutline{"HoleOutside", {Square(0, 0, 1), {Square(2, 2, 1)}}, "hole 0: lies outside"},
        BadOutline{
            "HoleAcross", {Square(0, 0, 2), {Square(1, 1, 2)}}, "hole 0: crosses or touches"},
        BadOutline{"HolesCross",
                   {Square(0, 0, 9), {Square(1, 1, 3), Square(2, 2, 3)}},
                   "hole 1: crosses or touches the hole 0"},
        BadOutline{"HoleInHole",
                   {Square(0, 0, 9), {Square(1, 1, 5), Square(2, 2, 1)}},
                   "hole 1: overlaps hole 0"},
        BadOutline{"HoleOfTwo", {Square(0, 0, 9), {{{1, 1}, {2, 2}}}}, "hole 0: 2 points"}),
    [](const auto& row) { return std::string(row.param.name); });

// Reference: an L of a 2 x 1 and a 1 x 1 square, centroid from the squares' own; far from the
// origin.
TEST(OutlineTest, TheCentroidIsThatOfTheArea) {
  const Eigen::Vector2d far(1e3, -2e3);
  std::vector<Eigen::Vector2d> loop;
  for (const auto& p : {Eigen::Vector2d(0, 0), Eigen::Vector2d(2, 0), Eigen::Vector2d(2, 1),
                        Eigen::Vector2d(1, 1), Eigen::Vector2d(1, 2), Eigen::Vector2d(0, 2)}) {
    loop.push_back(p + far);
  }
  const Eigen::Vector2d expected = (2 * Eigen::Vector2d(1, 0.5) + Eigen::Vector2d(0.5, 1.5)) / 3;
  EXPECT_LT((Centroid(loop) - far - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace palpate
