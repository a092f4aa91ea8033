#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "master/view/shape_layers.h"

namespace palpate {
namespace {

TEST(ScaleTest, EndsAreRoundAndNeverBelowTheValue) {
  EXPECT_NEAR(RoundedUp(0.42, 1e-3), 0.6, 1e-15);
  EXPECT_NEAR(RoundedUp(0.6, 1e-3), 0.6, 1e-15);
  EXPECT_NEAR(RoundedUp(8.1, 1e-3), 10, 1e-12);
  EXPECT_NEAR(RoundedUp(0, 0.05), 0.06, 1e-15);
  for (double value = 1e-9; value < 1e9; value *= 1.7) {
    const double end = RoundedUp(value, 1e-12);
    EXPECT_GE(end, value * (1 - 1e-9));
    EXPECT_LE(end, 2.0001 * value);
  }
  EXPECT_TRUE(std::isfinite(RoundedUp(std::numeric_limits<double>::infinity(), 1)));
  EXPECT_TRUE(std::isfinite(RoundedUp(std::nan(""), 1)));
}

// Luminance after ITU-R BT.709; it must fall all the way, for eyes that see no colours.
TEST(ScaleTest, MoreIsDarker) {
  const auto luminance = [](const std::string& colour) {
    const auto channel = [&](std::size_t at) {
      return std::stoi(colour.substr(at, 2), nullptr, 16);
    };
    return 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
  };
  double last = 256;
  for (int i = 0; i <= 20; ++i) {
    const std::string colour = ColourOf(i / 20.0);
    ASSERT_EQ(colour.size(), 7U);
    EXPECT_LT(luminance(colour), last) << i;
    last = luminance(colour);
    EXPECT_LT(luminance(ColourOf(i / 20.0, 0.8)), last) << "less light";
  }
  EXPECT_EQ(ColourOf(std::nan("")), ColourOf(0));
  EXPECT_EQ(ColourOf(7), ColourOf(1));
}

}  // namespace
}  // namespace palpate
