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
    scene_ = site::BlockScene();
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
  const site::TrueBody body(scene_);
  const auto place = body.Nearest({0.044, 0.09});
  const site::PatchSolution wide =
      SolveUnderRound(body, kNu, Plane::kStrain, place, {12e-3, kRadius});
  double last = 0;
  for (const double depth : {0.2e-3, 0.5e-3, 1e-3}) {
    const site::RoundState state = Touched(*wide.round, {0, -depth});
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

}  // namespace
}  // namespace palpate
