#include "slave/site/camera/painter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/site/camera/simulated_site.h"
#include "slave/vision/observation.h"
#include "tests/slave/site/camera/site_scenes.h"

namespace palpate::site {
namespace {

// No noise, even light: what is left is the drawing itself, blurred.
Scene CleanBlock() {
  Scene scene = BlockScene();
  scene.site.noise = 0;
  scene.site.lighting = 0;
  scene.site.flicker = 0;
  return scene;
}

cv::Mat Picture(const Scene& scene, const Eigen::Vector3d& p_S_tip) {
  SimulatedSite site(scene);
  site.MoveTool(p_S_tip);
  return site.TakePicture();
}

// Where a step from level `before` to level `after` lies best in `profile`, whose first sample is
// at 0 [samples]: an area-sampled edge behind the Gaussian of `sigma` that OpenCV samples.
double FitStep(const std::vector<double>& profile, double before, double after, double sigma) {
  constexpr int kReach = 3;
  const cv::Mat kernel = cv::getGaussianKernel(2 * kReach + 1, sigma, CV_64F);
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (double at = 0; at < static_cast<double>(profile.size()); at += 1e-3) {
    double sum = 0;
    for (std::size_t i = 0; i < profile.size(); ++i) {
      double part = 0;
      for (int k = -kReach; k <= kReach; ++k) {
        const double covered = static_cast<double>(i) + k + 0.5 - at;
        part += kernel.at<double>(k + kReach) * std::clamp(covered, 0.0, 1.0);
      }
      const double miss = profile[i] - before - (after - before) * part;
      sum += miss * miss;
    }
    if (sum < least) {
      least = sum;
      best = at;
    }
  }
  return best;
}

std::vector<double> MeanOver(const cv::Mat& picture, const cv::Rect& window, bool rows) {
  cv::Mat mean;
  cv::reduce(picture(window), mean, rows ? 1 : 0, cv::REDUCE_AVG, CV_64F);
  return {mean.begin<double>(), mean.end<double>()};
}

Eigen::Vector2d ToImage(const Scene& scene, double x, double y) {
  return CameraView(*scene.sense.Find<Camera>(), 640, 480).ToImage({x, y, 0});
}

// Fitted places of the block's top edge (over the columns right of the tool) and left edge, less
// the expected place of the corner [px].
Eigen::Vector2d CornerError(const cv::Mat& picture, const Eigen::Vector2d& corner) {
  const int x = static_cast<int>(corner.x()) - 4, y = static_cast<int>(corner.y()) - 4;
  const auto across = MeanOver(picture, {x, 180, 9, 220}, false);
  const auto down = MeanOver(picture, {340, y, 90, 9}, true);
  return {x + FitStep(across, Painter::kGround, Painter::kBody, 0.7) - corner.x(),
          y + FitStep(down, Painter::kGround, Painter::kBody, 0.7) - corner.y()};
}

// Reference: the camera's mapping of the true corner. Tolerance: over one picture the speckle's
// mean along the edge deviates by 7.5 / sqrt(30 grains) = 1.4 grey levels over the two or three
// rows that decide, which moves the fit by some 0.04 px; over 16 seeds, by 0.01 px, thrice of which
// is allowed. The drawing itself is exact (coverage_test).
TEST(Painter, RestEdgesAreDrawnWhereTheBodyReallyLies) {
  for (const Eigen::Vector2d& shift : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.21e-3, -0.13e-3),
                                       Eigen::Vector2d(-0.5e-3, 0.4e-3)}) {
    Scene scene = CleanBlock();
    scene.site.misplacement = shift;
    const Eigen::Vector2d corner = ToImage(scene, shift.x(), 0.088 + shift.y());
    Eigen::Vector2d error(0, 0);
    for (scene.site.seed = 1; scene.site.seed <= 16; ++scene.site.seed) {
      error += CornerError(Picture(scene, scene.manipulator.home), corner) / 16;
    }
    EXPECT_LT(error.norm(), 0.03) << shift.transpose() << ": " << error.transpose();
  }
}

// Reference: the camera's mapping of the tip. The marks are two-valued with grains of four pixels,
// so eleven columns hold about three of them: 25 / sqrt(3) levels of a step of 150, over the two
// rows that decide, move the fit by some 0.13 px in one picture, by 0.03 px over 16 seeds, thrice
// of which is allowed.
TEST(Painter, TheToolsTipIsDrawnWhereItIsTold) {
  Scene scene = CleanBlock();
  for (const double y : {0.0902, 0.0913, 0.0987}) {
    const Eigen::Vector2d tip = ToImage(scene, 0.044, y);
    const int first = static_cast<int>(tip.y()) - 4, column = static_cast<int>(tip.x());
    const double left = ToImage(scene, 0.044 - scene.tool->width / 2, y).x();
    const double mean = 0.5 * (Painter::kToolDark + Painter::kToolLight);
    double along = 0, across = 0;
    for (scene.site.seed = 1; scene.site.seed <= 16; ++scene.site.seed) {
      const cv::Mat picture = Picture(scene, {0.044, y, 0});
      const auto down = MeanOver(picture, {column - 5, first, 11, 9}, true);
      along += (first + FitStep(down, mean, Painter::kGround, 0.7) - tip.y()) / 16;
      const auto right = MeanOver(picture, {column - 13, 20, 9, 60}, false);
      across += (column - 13 + FitStep(right, Painter::kGround, mean, 0.7) - left) / 16;
    }
    EXPECT_NEAR(along, 0, 0.1) << y;
    EXPECT_NEAR(across, 0, 0.1) << y;
  }
}

// The body follows the tool: under the pressed patch the surface is where the tip is, and the
// corners, far away, have hardly moved.
TEST(Painter, ThePressedSurfaceFollowsTheTip) {
  const Scene scene = CleanBlock();
  SimulatedSite site(scene);
  site.MoveTool({0.044, 0.089, 0});
  site.MoveTool({0.044, 0.083, 0});
  const cv::Mat picture = site.TakePicture();
  const Eigen::Vector2d tip = ToImage(scene, 0.044, 0.083), rest = ToImage(scene, 0.044, 0.088);
  const int column = static_cast<int>(std::lround(tip.x()));
  const auto grey = [&](double x, double y) {
    return picture.at<std::uint8_t>(static_cast<int>(std::lround(y)),
                                    static_cast<int>(std::lround(x)));
  };
  EXPECT_LT(grey(column, tip.y() - 4), 85) << "tool above the tip";
  EXPECT_GT(grey(column, tip.y() + 4), 90) << "body below the tip";
  EXPECT_LT(grey(column, tip.y() + 4), 130);
  EXPECT_GT(grey(column + 14, rest.y() + 2), 150) << "the surface beside the tool has sunk";
}

TEST(Painter, TheSameCallsGiveTheSamePictures) {
  const auto film = [](std::uint32_t seed) {
    Scene scene = BlockScene();
    scene.site.seed = seed;
    SimulatedSite site(scene);
    std::vector<cv::Mat> pictures;
    for (int k = 0; k < 4; ++k) {
      site.MoveTool({0.044, 0.0885 - 1e-3 * k, 0});
      pictures.push_back(site.TakePicture());
    }
    return pictures;
  };
  const auto one = film(1), again = film(1), other = film(2);
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(cv::norm(one[k], again[k], cv::NORM_INF), 0) << k;
    EXPECT_GT(cv::norm(one[k], other[k], cv::NORM_INF), 0) << k;
  }
}

// Reference: the scene's sigma. Rounding to whole grey levels adds 1 / 12; 1 % of 4e4 pixels'
// worth.
TEST(Painter, NoiseHasTheSceneSigma) {
  Scene scene = CleanBlock();
  scene.site.noise = 3;
  SimulatedSite site(scene);
  const cv::Mat a = site.TakePicture();
  cv::Scalar mean, deviation;
  cv::meanStdDev(a({0, 0, 150, 470}), mean, deviation);
  EXPECT_NEAR(deviation[0], std::sqrt(9 + 1.0 / 12), 0.05);
  EXPECT_NEAR(mean[0], Painter::kGround, 0.1);
}

TEST(Painter, LightFallsTowardsTheLowerRight) {
  Scene scene = CleanBlock();
  scene.site.lighting = 0.2;
  const cv::Mat picture = Picture(scene, scene.manipulator.home);
  EXPECT_EQ(picture.at<std::uint8_t>(0, 0), 200);
  EXPECT_NEAR(picture.at<std::uint8_t>(479, 639), 160, 1);
}

// A tool outside the picture, a body outside the picture, a picture full of body: all drawable.
TEST(Painter, ThingsOutsideThePictureAreHarmless) {
  Scene scene = CleanBlock();
  scene.sense.Find<Camera>()->X_SC.translation() << 10, 10, 0;
  const cv::Mat nothing = Picture(scene, scene.manipulator.home);
  EXPECT_EQ(cv::norm(nothing, cv::Mat(480, 640, CV_8U, cv::Scalar(200)), cv::NORM_INF), 0);
  scene = CleanBlock();
  scene.sense.Find<Camera>()->pixel = 0.01e-3;
  SimulatedSite site(scene);
  site.MoveTool({0.044, 0.089, 0});
  site.MoveTool({0.044, 0.080, 0});
  EXPECT_LT(cv::mean(site.TakePicture())[0], 130);
}

}  // namespace
}  // namespace palpate::site
