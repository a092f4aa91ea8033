#include "slave/simulator/fingertips/simulated_fingertip.h"

#include <numbers>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Reference: area of a half sphere and of a cylinder, 2 pi r^2 + 2 pi r L, in closed form.
TEST(SkinSurface, PiecesAddUpToTheWholeSkin) {
  const site::SkinSurface skin = site::MakeSkinSurface();
  double area = 0;
  for (const double piece : skin.area) area += piece;
  const double r = site::kSkinRadius, L = 16e-3;
  EXPECT_NEAR(area, 2 * std::numbers::pi * r * (r + L), 1e-9 * area);
}

}  // namespace
}  // namespace palpate
