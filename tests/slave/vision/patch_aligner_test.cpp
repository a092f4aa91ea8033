#include "slave/vision/patch_aligner.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/slave/vision/texture/texture_images.h"

namespace palpate {
namespace {

using Freedom = PatchAligner::Freedom;

// Returns the new position of the texture point that was at `centre` in the first image.
Eigen::Vector2d Moved(const PatchWarp& by, const Eigen::Vector2d& centre) {
  return by.A * centre + by.p;
}

// Reference: the texture is known between the pixels, so the shift is exact. Tolerance: linear
// interpolation of waves of 6 px and more.
TEST(PatchAlignerTest, ShiftsByPartsOfAPixelAreFound) {
  WavyTexture texture;
  const cv::Mat first = texture.Image({});
  PatchAligner window(31);
  ASSERT_TRUE(window.Cut(first, Shifted(150, 110)));
  for (const double shift : {0.1, 0.25, 0.5, 0.75, 1.3, 2.6}) {
    const PatchWarp by = Shifted(shift, -0.6 * shift);
    const auto match = window.Align(texture.Image(by), Shifted(150, 110), Freedom::kShift);
    ASSERT_TRUE(match.converged) << shift;
    EXPECT_LT((match.warp.p - Moved(by, {150, 110})).norm(), 0.03) << shift;
    EXPECT_GT(match.correlation, 0.99);
  }
}

// Reference: the warp the image was drawn with. A mistake of an element of A by 0.003 moves the
// window's edge by 0.05 px.
TEST(PatchAlignerTest, AffineWarpsAndLightAreFoundTogether) {
  WavyTexture texture;
  const cv::Mat first = texture.Image({});
  const Eigen::Vector2d centre(150, 110);
  PatchAligner window(31);
  ASSERT_TRUE(window.Cut(first, {Eigen::Matrix2d::Identity(), centre}));
  PatchWarp by;
  by.A << 1.08, 0.05, -0.04, 0.95;
  by.p = centre - by.A * centre + Eigen::Vector2d(1.2, -0.7);
  const auto match = window.Align(texture.Image(by, 0, 0.7, 30),
                                  {Eigen::Matrix2d::Identity(), centre}, Freedom::kAffine);
  ASSERT_TRUE(match.converged);
  EXPECT_LT((match.warp.p - Moved(by, centre)).norm(), 0.03);
  EXPECT_LT((match.warp.A - by.A).cwiseAbs().maxCoeff(), 0.003);
}

// Reference: the errors for images with independent noise and all subpixel shifts. Tolerance: the
// mean of 120 squares of a normal error scatters by 13 %; linear interpolation adds a little.
TEST(PatchAlignerTest, CovarianceIsThatOfTheMissesUnderNoise) {
  WavyTexture texture;
  const cv::Size size(100, 100);
  PatchAligner window(15);
  ASSERT_TRUE(window.Cut(texture.Image({}, 0, 1, 0, size), Shifted(50, 50)));
  double square = 0;
  constexpr int kImages = 60;
  for (int k = 0; k < kImages; ++k) {
    const PatchWarp by = Shifted(std::fmod(0.37 * k, 1.0), std::fmod(0.61 * k, 1.0));
    const auto match =
        window.Align(texture.Image(by, 8, 1, 0, size), Shifted(50.5, 50.5), Freedom::kAffine);
    ASSERT_TRUE(match.converged);
    const Eigen::Vector2d miss = match.warp.p - Moved(by, {50, 50});
    square += miss.dot(match.covariance.inverse() * miss) / (2 * kImages);
  }
  EXPECT_GT(square, 0.6);
  EXPECT_LT(square, 1.5);
}

TEST(PatchAlignerTest, WindowsWithoutAPlaceAreRefused) {
  const cv::Mat flat(240, 320, CV_8UC1, cv::Scalar(100));
  cv::Mat stripes(240, 320, CV_8UC1);
  for (int x = 0; x < 320; ++x) {
    stripes.col(x).setTo(100 + 50 * std::sin(0.5 * x));
  }
  PatchAligner window(31);
  EXPECT_FALSE(window.Cut(flat, Shifted(150, 110)));
  EXPECT_FALSE(window.Cut(stripes, Shifted(150, 110)));
  const cv::Mat textured = WavyTexture().Image({});
  EXPECT_TRUE(window.Cut(textured, Shifted(17, 17)));
  EXPECT_FALSE(window.Cut(textured, Shifted(15, 110)));
  EXPECT_FALSE(window.Cut(textured, Shifted(150, 239)));
  EXPECT_FALSE(window.Cut(textured, Shifted(std::numeric_limits<double>::quiet_NaN(), 110)));
  EXPECT_FALSE(window.Cut(textured, Shifted(1e300, 110)));
  EXPECT_FALSE(window.Align(textured, Shifted(150, 110), Freedom::kShift).converged);
  EXPECT_EQ(window.Score(textured, Shifted(150, 110)), -1);
}

}  // namespace
}  // namespace palpate
