#include "slave/contact/boundary_contact.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/slave/contact/random_outline.h"
#include "tests/support/allocation_count.h"
#include "tests/support/not_finite.h"

namespace palpate {
namespace {

// The silicone block, 88 mm square; tolerances are the rounding of its coordinates.
class BlockContactTest : public ::testing::Test {
 protected:
  BoundaryContact contact_{MeshRectangle(0.088, 0.088, 60), 0};
};

TEST_F(BlockContactTest, ReportsTheNearestPlaceWhileOutside) {
  const BoundaryPlace& place = contact_.Move({0.030, 0.098});
  EXPECT_FALSE(contact_.in_contact());
  EXPECT_NEAR(place.gap, 0.010, 1e-15);
  EXPECT_LT((place.p_O - Eigen::Vector2d(0.030, 0.088)).norm(), 1e-15);
  EXPECT_EQ(place.normal_O, Eigen::Vector2d(0, 1));
  contact_.Move({0.120, 0.098});
  EXPECT_NEAR(contact_.Move({0.120, 0.050}).gap, 0.032, 1e-15);
  EXPECT_EQ(contact_.Move({0.120, 0.050}).normal_O, Eigen::Vector2d(1, 0));
  EXPECT_FALSE(contact_.in_contact());
}

// A round end of 10 mm; references: a circle and a straight line, a circle and a corner.
class RoundContactTest : public ::testing::Test {
 protected:
  BoundaryContact contact_{MeshRectangle(0.088, 0.088, 60), 0.010};
};

// Tolerance of the place: the search ends within a millionth of the radius.
TEST_F(RoundContactTest, TouchesBelowItsCentreWhereItComesNearFirst) {
  EXPECT_NEAR(contact_.Move({0.044, 0.0985}).gap, 0.0005, 1e-15);
  EXPECT_FALSE(contact_.in_contact());
  const BoundaryPlace& place = contact_.Move({0.047, 0.097});  // touches after a third of the way
  EXPECT_TRUE(contact_.in_contact());
  EXPECT_NEAR(place.gap, -0.001, 1e-15);
  EXPECT_LT((place.p_O - Eigen::Vector2d(0.045, 0.088)).norm(), 2e-8);
  EXPECT_LT((place.normal_O - Eigen::Vector2d(0, 1)).norm(), 1e-12);
}

TEST_F(RoundContactTest, StaysWhereItBeganUntilItLeaves) {
  contact_.Move({0.044, 0.099});
  contact_.Move({0.044, 0.097});
  const BoundaryPlace& place = contact_.Move({0.050, 0.090});
  EXPECT_NEAR(place.p_O.x(), 0.044, 1e-15);
  EXPECT_NEAR(place.gap, -0.008, 1e-15);
  contact_.Move({0.050, 0.0981});
  EXPECT_FALSE(contact_.in_contact());
  EXPECT_NEAR(place.p_O.x(), 0.050, 1e-15);
}

TEST_F(RoundContactTest, TouchesACornerTowardsItsCentre) {
  const double aside = 0.006;
  const BoundaryPlace& place = contact_.Move({0.088 + aside, 0.088 + aside});
  EXPECT_TRUE(contact_.in_contact());
  EXPECT_NEAR(place.gap, std::hypot(aside, aside) - 0.010, 1e-15);
  EXPECT_LT((place.p_O - Eigen::Vector2d(0.088, 0.088)).norm(), 1e-15);
  EXPECT_LT((place.normal_O - Eigen::Vector2d(1, 1).normalized()).norm(), 1e-12);
}

TEST_F(RoundContactTest, WithItsCentreInsideItIsDeeperThanItsRadius) {
  contact_.Move({0.044, 0.099});
  EXPECT_NEAR(contact_.Move({0.044, 0.085}).gap, -0.013, 1e-15);
}

TEST_F(BlockContactTest, BeginsWhereThePathCrossesTheBoundary) {
  contact_.Move({0.030, 0.090});
  const BoundaryPlace& place = contact_.Move({0.034, 0.086});  // crosses half-way
  EXPECT_TRUE(contact_.in_contact());
  EXPECT_LT((place.p_O - Eigen::Vector2d(0.032, 0.088)).norm(), 1e-15);
  EXPECT_NEAR(place.gap, -0.002, 1e-15);
}

TEST_F(BlockContactTest, SticksUntilTheTipComesOutThroughThePlane) {
  contact_.Move({0.044, 0.090});
  contact_.Move({0.044, 0.087});
  for (const Eigen::Vector2d& tip :
       {Eigen::Vector2d(0.050, 0.083), Eigen::Vector2d(0.060, 0.0879),
        Eigen::Vector2d(0.100, 0.040), Eigen::Vector2d(0.044, 0.001)}) {
    const BoundaryPlace& place = contact_.Move(tip);
    EXPECT_TRUE(contact_.in_contact()) << tip.transpose();
    EXPECT_LT((place.p_O - Eigen::Vector2d(0.044, 0.088)).norm(), 1e-15);
    EXPECT_NEAR(place.gap, tip.y() - 0.088, 1e-15);
  }
  EXPECT_GT(contact_.Move({0.060, 0.0885}).gap, 0);
  EXPECT_FALSE(contact_.in_contact());
}

TEST_F(BlockContactTest, TakesATipThatStartsInsideToTheNearestPlace) {
  const BoundaryPlace& place = contact_.Move({0.044, 0.083});
  EXPECT_TRUE(contact_.in_contact());
  EXPECT_LT((place.p_O - Eigen::Vector2d(0.044, 0.088)).norm(), 1e-15);
  EXPECT_NEAR(place.gap, -0.005, 1e-15);
}

TEST_F(BlockContactTest, ATipOnTheBoundaryIsNotYetInContact) {
  contact_.Move({0.030, 0.088});
  EXPECT_FALSE(contact_.in_contact());
  contact_.Move({0.050, 0.088});  // slides along it
  EXPECT_FALSE(contact_.in_contact());
  contact_.Move({0.050, 0.0879});
  EXPECT_TRUE(contact_.in_contact());
  contact_.Move({0.050, 0.088});
  EXPECT_FALSE(contact_.in_contact());
}

TEST_F(BlockContactTest, MayEnterElsewhereInTheSameMotion) {
  // A U-shaped body: the path leaves through the inner wall of the left arm, crosses the gap and
  // enters the right arm.
  BoundaryContact u(
      MeshPolygon({{{0, 0}, {5, 0}, {5, 4}, {3, 4}, {3, 1}, {2, 1}, {2, 4}, {0, 4}}, {}}, 60), 0);
  u.Move({2.5, 3});
  u.Move({1.9, 3});
  ASSERT_TRUE(u.in_contact());
  const BoundaryPlace& place = u.Move({3.5, 3});
  EXPECT_TRUE(u.in_contact());
  EXPECT_LT((place.p_O - Eigen::Vector2d(3, 3)).norm(), 1e-14);
  EXPECT_EQ(place.normal_O, Eigen::Vector2d(-1, 0));
}

TEST_F(BlockContactTest, IgnoresWhatIsNoPlace) {
  contact_.Move({0.044, 0.090});
  contact_.Move({0.044, 0.086});
  const BoundaryPlace before = contact_.Move({0.044, 0.085});
  for (const Eigen::Vector2d& tip : {Eigen::Vector2d(kNan, 0), Eigen::Vector2d(0, kInf),
                                     Eigen::Vector2d(1e300, 1e300), Eigen::Vector2d(0, -1e300)}) {
    const BoundaryPlace& place = contact_.Move(tip);
    EXPECT_TRUE(contact_.in_contact());
    EXPECT_EQ(place.p_O, before.p_O);
    EXPECT_EQ(place.gap, before.gap);
  }
  BoundaryContact fresh(MeshRectangle(1, 1, 4), 0);
  EXPECT_EQ(fresh.Move({kNan, kNan}).element, -1);
  EXPECT_FALSE(fresh.in_contact());
}

TEST_F(BlockContactTest, ForgetsOnReset) {
  contact_.Move({0.044, 0.090});
  contact_.Move({0.044, 0.086});
  contact_.Reset();
  EXPECT_FALSE(contact_.in_contact());
  EXPECT_GT(contact_.Move({0.044, -0.5}).gap, 0);  // no path through the block is remembered
  EXPECT_FALSE(contact_.in_contact());
}

// A law over random walks: in contact exactly while the tip is behind the plane of its place, and
// never inside the body without contact. The walk is the same for every numbering.
TEST(BoundaryContactTest, OnRandomWalksTheTipIsNeverInsideWithoutContact) {
  std::mt19937 random(5);
  std::normal_distribution<double> step(0, 0.08);
  int contacts = 0;
  for (int body = 0; body < 40; ++body) {
    const Outline outline = RandomOutline(&random);
    const BoundaryMesh mesh = MeshPolygon(outline, 150);
    BoundaryContact contact(mesh, 0), other(Renumbered(mesh, 37), 0);
    Eigen::Vector2d tip(1.2, 0);
    for (int i = 0; i < 1000; ++i) {
      tip = 0.99 * (tip + Eigen::Vector2d(step(random), step(random)));
      const BoundaryPlace place = contact.Move(tip);
      EXPECT_EQ(contact.in_contact(), place.gap < 0);
      EXPECT_TRUE(contact.in_contact() || !Contains(outline, tip)) << "body " << body << " " << i;
      EXPECT_EQ(place.p_O, other.Move(tip).p_O);
      EXPECT_EQ(contact.in_contact(), other.in_contact());
      contacts += contact.in_contact();
    }
  }
  EXPECT_GT(contacts, 4000);
}

TEST(BoundaryContactTest, AllocatesNothingWhileMoving) {
  std::mt19937 random(6);
  std::normal_distribution<double> step(0, 0.08);
  BoundaryContact contact(MeshPolygon(RandomOutline(&random), 500), 0);
  Eigen::Vector2d tip(1.2, 0);
  const long before = AllocationCount();
  for (int i = 0; i < 10000; ++i) {
    tip = 0.99 * (tip + Eigen::Vector2d(step(random), step(random)));
    contact.Move(tip);
  }
  EXPECT_EQ(AllocationCount() - before, 0);
}

}  // namespace
}  // namespace palpate
