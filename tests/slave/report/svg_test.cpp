#include "slave/report/svg.h"

#include <array>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/report/well_formed.h"

namespace palpate {
namespace {

using testing::HasSubstr;

TEST(SvgTest, EveryShapeIsWellFormedWhateverTheWords) {
  const std::string nasty = "<a> & \"b\" \n\x01";
  Svg svg(100, 50, nasty, ".c { fill: red; }\n");
  svg.Line({0, 0}, {1, 1}, nasty);
  const std::vector<Eigen::Vector2d> corners{{0, 0}, {1, 1}, {1, 0}};
  svg.Polyline(corners, "c");
  svg.Rectangle({1, 2}, {3, 4}, "c");
  svg.Circle({1, 2}, 3, "c", nasty);
  svg.Text({5, 5}, nasty, "c", Svg::Anchor::kEnd, -90);
  EXPECT_EQ(NotWellFormed(svg.Document()), "");
}

TEST(SvgTest, NumbersThatAreNoneAreNotWritten) {
  Svg drawing(10, 10, "", "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array<Eigen::Vector2d, 3> corners{Eigen::Vector2d(nan, 1), Eigen::Vector2d(1e300, 2),
                                               Eigen::Vector2d(-1e300, 3)};
  drawing.Polyline(corners, "c");
  EXPECT_THAT(drawing.Document(), HasSubstr("points=\"0.0,1.0 100000.0,2.0 -100000.0,3.0\""));
}

}  // namespace
}  // namespace palpate
