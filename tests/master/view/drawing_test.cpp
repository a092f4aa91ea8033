#include "master/view/drawing.h"

#include <array>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(DrawingTest, WordsFromElsewhereCannotBreakTheDocument) {
  Drawing drawing(10, 10, "a < b & \"c\"", "");
  drawing.Text({1, 2}, "<script>\x01&", "ink");
  const std::string text = drawing.Document();
  EXPECT_THAT(text, HasSubstr("<title>a &lt; b &amp; &quot;c&quot;</title>"));
  EXPECT_THAT(text, HasSubstr(">&lt;script> &amp;</text>"));
  EXPECT_THAT(text, Not(HasSubstr("\x01")));
}

TEST(DrawingTest, NumbersThatAreNoneAreNotWritten) {
  Drawing drawing(10, 10, "", "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array<Eigen::Vector2d, 3> corners{Eigen::Vector2d(nan, 1), Eigen::Vector2d(1e300, 2),
                                               Eigen::Vector2d(-1e300, 3)};
  drawing.Polygon(corners, "#ffffff");
  EXPECT_THAT(drawing.Document(), HasSubstr("points=\"0.0,1.0 100000.0,2.0 -100000.0,3.0\""));
}

TEST(DrawingTest, GroupsAreClosed) {
  Drawing drawing(10, 10, "", "");
  drawing.BeginGroup("near");
  drawing.Circle({1, 1}, 2, "ring");
  drawing.EndGroup();
  EXPECT_THAT(drawing.Document(),
              HasSubstr("<g class=\"near\">\n<circle class=\"ring\" cx=\"1.0\" cy=\"1.0\" "
                        "r=\"2.0\"/>\n</g>\n</svg>\n"));
}

}  // namespace
}  // namespace palpate
