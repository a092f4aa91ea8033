#include "slave/reference/planar/round_touch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/slave/reference/planar/planar_scenes.h"

namespace palpate {
namespace {

// The block of silicone in plane strain under a cylinder.
class RoundTouchTest : public testing::Test {
 protected:
  static constexpr double kRadius = 8e-3, kNu = 0.3;
  RoundTouchTest() {
    scene_ = simulation::BlockScene();
    scene_.model.plane = Plane::kStrain;
    scene_.object.material.poisson_ratio = kNu;
    scene_.tool = Tool{.shape = Tool::Shape::kRound, .width = 12e-3, .radius = kRadius};
  }
  Scene scene_;
};

// Reference: Hertz for a cylinder on a half-plane, a^2 = 4 P R / (pi E*) (Johnson, 4.43), E = 1,
// force per thickness; frictionless there, bonded here, which by Dundurs' constant of nu = 0.3
// makes the contact a few per cent narrower. In his range: a up to 0.3 R, 1/30 of the block.
// Tolerance: half a node's distance of 0.25 mm at either end and 5 %.
TEST_F(RoundTouchTest, TheContactIsAsWideAsHertzHasIt) {
  const simulation::TrueBody body(scene_);
  const auto place = body.Nearest({0.044, 0.09});
  const simulation::PatchSolution wide =
      SolveUnderRound(body, kNu, Plane::kStrain, place,
                      {.shape = Tool::Shape::kRound, .width = 12e-3, .radius = kRadius});
  double last = 0;
  for (const double depth : {0.2e-3, 0.5e-3, 1e-3}) {
    const simulation::RoundState state = Touched(*wide.round, {0, -depth}, 0);
    const double P = -state.total().y();
    double a = 0;
    for (std::size_t i = 0; i < wide.round->nodes.size(); ++i) {
      if (state.force(2 * static_cast<Eigen::Index>(i) + 1) < 0) {
        a = std::max(a, std::abs(wide.round->nodes[i].x()));
      }
    }
    const double hertz = std::sqrt(4 * P * kRadius * (1 - kNu * kNu) / std::numbers::pi);
    EXPECT_NEAR(a, hertz, 0.3e-3 + 0.05 * hertz) << depth;
    EXPECT_GT(a, last);
    last = a;
  }
}

// References: the flat bonded solution on its own graded mesh, whose stiffness is within 1e-3, and
// statics. Tolerance: 1 % of the stiffness, for the coarser mesh and the released nodes.
TEST_F(RoundTouchTest, AStraightFacePressesLikeTheBondedTool) {
  const simulation::TrueBody body(scene_);
  const auto place = body.Nearest({0.044, 0.09});
  const simulation::PatchSolution face =
      SolveUnderRound(body, kNu, Plane::kStrain, place, {.width = 12e-3});
  const simulation::PatchSolution bonded = SolvePatch(body, kNu, Plane::kStrain, place, 12e-3);
  constexpr double kDepth = 2e-3;
  const double wanted = kDepth * bonded.stiffness(1, 1);
  EXPECT_NEAR(-Touched(*face.round, {0, -kDepth}, 0).total().y(), wanted, 0.01 * wanted);
}

// A tool rotated counter-clockwise has its left corner in front, which touches first and alone. The
// mirrored tool gives the mirrored force.
TEST_F(RoundTouchTest, ATiltedFaceTouchesWithItsLeadingCornerFirst) {
  const simulation::TrueBody body(scene_);
  const auto place = body.Nearest({0.044, 0.09});
  const simulation::PatchSolution face =
      SolveUnderRound(body, kNu, Plane::kStrain, place, {.width = 12e-3});
  constexpr double kTilt = 0.2, kBefore = 0.5e-3;  // the corner leads by 1.2 mm
  const simulation::RoundState left = Touched(*face.round, {0, kBefore}, kTilt);
  const simulation::RoundState right = Touched(*face.round, {0, kBefore}, -kTilt);
  ASSERT_LT(left.total().y(), 0);
  EXPECT_NEAR(left.total().y(), right.total().y(), 0.01 * std::abs(left.total().y()));
  for (std::size_t i = 0; i < face.round->nodes.size(); ++i) {
    if (left.force(2 * static_cast<Eigen::Index>(i) + 1) < 0) {
      EXPECT_LT(face.round->nodes[i].x(), 0);
    }
  }
  EXPECT_EQ(Touched(*face.round, {0, 2e-3}, kTilt).total().norm(), 0);
}

}  // namespace
}  // namespace palpate
