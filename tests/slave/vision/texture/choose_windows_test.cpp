#include <gtest/gtest.h>

#include "slave/vision/patch_aligner.h"
#include "slave/vision/texture/flow_tracker.h"
#include "tests/slave/vision/texture/texture_images.h"

namespace palpate {
namespace {

// Reference: chosen windows can be cut as templates, do not overlap and lie inside the image.
TEST(ChooseWindowsTest, ChosenWindowsHaveTextureLieApartAndInside) {
  cv::Mat image = WavyTexture().Image({}, 2);
  image(cv::Rect(0, 0, 150, 240)).setTo(90);
  const auto centres = ChooseWindows(image, 12, 31, 20);
  ASSERT_GE(centres.size(), 4U);
  ASSERT_LE(centres.size(), 12U);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    PatchAligner window(31);
    EXPECT_TRUE(window.Cut(image, {Eigen::Matrix2d::Identity(), centres[i]}));
    EXPECT_GT(centres[i].x(), 130);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((centres[i] - centres[j]).norm(), 20);
  }
}

}  // namespace
}  // namespace palpate
