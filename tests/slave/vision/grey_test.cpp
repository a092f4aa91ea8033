#include "slave/vision/grey.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace palpate {
namespace {

std::int16_t Level(const cv::Mat& image) {
  const GreyFormat format(image);
  GreyPatch patch;
  format.Read(image, {1, 1, 2, 1}, patch);
  return patch.At(1, 0);
}

// Reference: ITU-R BT.601: 0.114 B + 0.587 G + 0.299 R, here in 256ths and rounded.
TEST(GreyFormatTest, LevelsOfEveryAcceptedType) {
  EXPECT_EQ(Level(cv::Mat(4, 4, CV_8UC1, cv::Scalar(77))), 77);
  EXPECT_EQ(Level(cv::Mat(4, 4, CV_8UC3, cv::Scalar(255, 0, 0))), 29);
  EXPECT_EQ(Level(cv::Mat(4, 4, CV_8UC3, cv::Scalar(0, 255, 0))), 149);
  EXPECT_EQ(Level(cv::Mat(4, 4, CV_8UC3, cv::Scalar(0, 0, 255))), 77);
  EXPECT_EQ(Level(cv::Mat(4, 4, CV_16UC1, cv::Scalar(65535))), 2047);
  EXPECT_EQ(Level(cv::Mat(4, 4, CV_16UC1, cv::Scalar(4095))), 2047) << "a 12 bit camera";
  EXPECT_EQ(Level(cv::Mat(4, 4, CV_16UC1, cv::Scalar(200))), 200) << "no light, no gain";
  EXPECT_EQ(Level(cv::Mat(4, 4, CV_16UC3, cv::Scalar::all(1000))), 1000);
}

// The rows of an image cut out of a larger one are not contiguous in memory.
TEST(GreyFormatTest, CutOutImagesAreReadRowByRow) {
  cv::Mat large(10, 10, CV_8UC1);
  for (int k = 0; k < 100; ++k) large.data[k] = static_cast<uchar>(k);
  const cv::Mat part = large(cv::Rect(3, 2, 4, 4));
  GreyPatch patch;
  GreyFormat(part).Read(part, {1, 1, 2, 2}, patch);
  EXPECT_EQ(patch.levels, (std::vector<std::int16_t>{34, 35, 44, 45}));
}

}  // namespace
}  // namespace palpate
