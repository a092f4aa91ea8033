#include "slave/vision/rest_edge.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slave/vision/rest_contour.h"
#include "tests/slave/vision/test_images.h"

namespace palpate {
namespace {

TestImage BlockAtRest() {
  TestImage painting;
  painting.body.emplace();
  return painting;
}

RestEdge EdgeOf(const TestImage& painting) {
  const cv::Mat first = painting.Render();
  const GreyFormat format(first);
  return {first, format, FindRestContour({}, first, format, 0, false).edge};
}

// Reference: the drawn block, moved by a known displacement. Mean and spread over all places: 0.03
// px and 0.12 px at the default noise and texture.
TEST(RestEdgeTest, EachPlaceMeasuresTheMotionOfTheEdgeAcross) {
  RestEdge edge = EdgeOf(BlockAtRest());
  ASSERT_GT(edge.places().size(), 150U);
  TestImage moved = BlockAtRest();
  const Eigen::Vector2d way(1.7, -2.6);
  moved.body->centre += way;
  const cv::Mat image = moved.Render(7);
  double mean = 0, square = 0;
  int seen = 0;
  for (const RestEdge::Place& place : edge.places()) {
    const auto offset = edge.Locate(image, place, place.p_I, place.n_I, 5);
    if (!offset) continue;
    const double error = *offset - place.n_I.dot(way);
    ++seen, mean += error, square += error * error;
  }
  EXPECT_GT(seen, 0.95 * static_cast<double>(edge.places().size()));
  EXPECT_NEAR(mean / seen, 0, 0.03);
  EXPECT_LT(std::sqrt(square / seen), 0.12);
}

}  // namespace
}  // namespace palpate
