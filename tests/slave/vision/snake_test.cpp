#include "slave/vision/snake.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/slave/vision/test_images.h"
#include "tests/support/references.h"

namespace palpate {
namespace {

// Reference: the table (Williams & Shah's normalisations in exact arithmetic), energies to 1e-12.
TEST(GreedyStepTest, ReproducesTheReferenceTable) {
  PALPATE_CASE_OR_SKIP(reference, "g_vision.json", "snake_greedy_step");
  const auto& params = reference.at("params");
  const auto vertex = [&](int k) {
    const auto v = params.at("vertices").at(k).get<std::vector<double>>();
    return Eigen::Vector2d(v[0], v[1]);
  };
  const auto place = [](const nlohmann::json& entry) {
    return static_cast<std::size_t>(3 * (entry.at("dx").get<int>() + 1) +
                                    entry.at("dy").get<int>() + 1);
  };
  NinePlaces magnitude{};
  for (const auto& entry : params.at("gradient_magnitude")) {
    magnitude[place(entry)] = entry.at("mag").get<double>();
  }
  const SnakeWeights weights{params.at("alpha"), params.at("beta"), params.at("gamma")};
  const auto& expected = reference.at("expected");
  const GreedyStep step = EvaluateStep(vertex(0), vertex(1), vertex(2), expected.at("mean_spacing"),
                                       weights, magnitude);
  for (const auto& entry : expected.at("energies")) {
    const std::size_t k = place(entry);
    EXPECT_NEAR(step.cont[k], entry.at("cont").get<double>(), 1e-12) << entry;
    EXPECT_NEAR(step.curv[k], entry.at("curv").get<double>(), 1e-12) << entry;
    EXPECT_NEAR(step.image[k], entry.at("image").get<double>(), 1e-12) << entry;
    EXPECT_NEAR(step.total[k], entry.at("total").get<double>(), 1e-12) << entry;
  }
  EXPECT_EQ(step.dx(), expected.at("move").at(0).get<int>());
  EXPECT_EQ(step.dy(), expected.at("move").at(1).get<int>());
}

Curve CircleAround(const Eigen::Vector2d& centre, double radius, int count) {
  Curve curve;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    curve.push_back(centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return curve;
}

TestImage Disc(double radius) {
  TestImage painting;
  painting.body.emplace();
  painting.body->shape = PaintedBody::Shape::kDisc;
  painting.body->centre = {320.4, 239.7};
  painting.body->half = {radius, radius};
  return painting;
}

// Reference: the disc's own radius. A point is on whole pixels, and the chain's pull inwards
// costs up to another: within 1.5 px everywhere. It starts as far off as the blurred edge reaches.
TEST(SnakeTest, CreepsOntoADiscFromOutsideAndInside) {
  const cv::Mat image = Disc(90).Render();
  const GreyFormat format(image);
  for (const double start : {88.5, 91.5}) {
    Snake snake(format, {}, CircleAround({320, 240}, start, 360), 60);
    EXPECT_LT(snake.Creep(image, 60), 60) << "it comes to rest";
    for (const Eigen::Vector2d& p : snake.points()) {
      EXPECT_NEAR((p - Eigen::Vector2d(320.4, 239.7)).norm(), 90, 1.5) << "from " << start;
    }
  }
}

TEST(SnakeTest, StaysInsideTheImage) {
  const cv::Mat flat(40, 50, CV_8UC1, cv::Scalar(100));
  Snake snake(GreyFormat(flat), {0, 0, 1}, CircleAround({25, 20}, 60, 90), 40);
  snake.Creep(flat, 10);
  for (const Eigen::Vector2d& p : snake.points()) {
    EXPECT_TRUE(p.x() >= 2 && p.y() >= 2 && p.x() <= 47 && p.y() <= 37) << p.transpose();
  }
}

}  // namespace
}  // namespace palpate
