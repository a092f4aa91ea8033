#include <gtest/gtest.h>

#include "slave/vision/template_match.h"
#include "tests/support/references.h"

namespace palpate {
namespace {

TEST(ParabolaTest, ReproducesTheReferenceTable) {
  PALPATE_CASE_OR_SKIP(reference, "g_vision.json", "subpixel_parabola");
  const auto y = reference.at("params").at("y").get<std::vector<double>>();
  const Vertex vertex = FitParabola(y.at(0), y.at(1), y.at(2));
  EXPECT_NEAR(vertex.offset, reference.at("expected").at("offset").get<double>(), 1e-14);
  EXPECT_NEAR(vertex.value, reference.at("expected").at("peak").get<double>(), 1e-14);
}

// Reference: y = 5 - 2 (x - d)^2 sampled at -1, 0, 1 has its vertex at d.
TEST(ParabolaTest, FindsTheVertexOfAParabola) {
  for (const double d : {-0.5, -0.2, 0.0, 0.31, 0.5}) {
    const auto y = [d](double x) { return 5 - 2 * (x - d) * (x - d); };
    const Vertex vertex = FitParabola(y(-1), y(0), y(1));
    EXPECT_NEAR(vertex.offset, d, 1e-14);
    EXPECT_NEAR(vertex.value, 5, 1e-14);
  }
}

TEST(ParabolaTest, ALineHasNoVertexAndKeepsItsMiddle) {
  EXPECT_EQ(FitParabola(2, 2, 2).offset, 0);
  EXPECT_EQ(FitParabola(1, 2, 3).offset, 0);
  EXPECT_EQ(FitParabola(1, 2, 3).value, 2);
}

}  // namespace
}  // namespace palpate
