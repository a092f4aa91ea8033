#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/vision/stereo/lens_warp.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

StereoRig Barrel() {
  StereoRig camera;
  camera.left = {300, 300, 160, 120, {-0.4, 0, 0, 0, 0}, {320, 240}};
  camera.right = camera.left;
  camera.X_RL.translation().x() = -0.06;
  return camera;
}

Camera CameraWith(const std::filesystem::path& lens) {
  Camera camera;
  camera.lens = lens;
  return camera;
}

std::string Message(const std::filesystem::path& lens, const cv::Mat& picture) {
  return Thrown<std::runtime_error>([&] { StraighteningOf(CameraWith(lens))(picture); });
}

TEST(StraighteningTest, WithoutALensThereIsNone) {
  EXPECT_FALSE(StraighteningOf(Camera{}));
}

// A white spot is moved to where a pinhole would see it.
TEST(StraighteningTest, PicturesOfALensComeStraight) {
  const Scratch scratch;
  const StereoRig camera = Barrel();
  WriteRig(scratch.path() / "lens.yaml", camera, true);
  const Eigen::Vector2d spot(290, 30);
  cv::Mat picture(240, 320, CV_8UC1, cv::Scalar(0));
  picture(cv::Rect(289, 29, 3, 3)) = 200;
  const cv::Mat straight = StraighteningOf(CameraWith(scratch.path() / "lens.yaml"))(picture);
  const cv::Moments m = cv::moments(straight);
  const Eigen::Vector2d seen(m.m10 / m.m00, m.m01 / m.m00);
  const Eigen::Vector2d expected = Straight(camera.left, spot).value();
  EXPECT_GT((expected - spot).norm(), 5);
  EXPECT_LT((seen - expected).norm(), 0.1);
}

TEST(StraighteningTest, ALensOfOtherPicturesIsNamed) {
  const Scratch scratch;
  const cv::Mat picture(24, 32, CV_8UC1, cv::Scalar(0));
  const auto file = scratch.path() / "lens.yaml";
  WriteRig(file, Barrel(), true);
  EXPECT_THAT(Message(file, picture), testing::HasSubstr("sense.camera.intrinsics"));
  EXPECT_THAT(Message(file, picture),
              testing::HasSubstr("320 x 240 px, but this image has 32 x 24"));
  WriteRig(file, Barrel());
  EXPECT_THAT(Message(file, picture), testing::HasSubstr("is for two cameras"));
  EXPECT_THAT(Message(scratch.path() / "none.yaml", picture), testing::HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace palpate
