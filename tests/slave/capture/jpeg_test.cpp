#include "slave/capture/jpeg.h"

#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace palpate {
namespace {

cv::Mat Decode(const std::string& coded) {
  return cv::imdecode(std::vector<unsigned char>(coded.begin(), coded.end()), cv::IMREAD_UNCHANGED);
}

cv::Mat Ramp(int type) {
  cv::Mat image(48, 64, type);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const int value = 2 * x + y;
      if (type == CV_8UC1) image.at<uchar>(y, x) = static_cast<uchar>(value);
      if (type == CV_16UC1) image.at<ushort>(y, x) = static_cast<ushort>(257 * value);
      if (type == CV_8UC3) image.at<cv::Vec3b>(y, x) = cv::Vec3b::all(static_cast<uchar>(value));
    }
  }
  return image;
}

// Reference: the picture itself. A ramp has no detail, so at quality 95 the quantisation steps of
// the standard's table leave at most a few grey levels.
TEST(EncodeJpegTest, PicturesSurviveTheRoundTrip) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1}) {
    const cv::Mat decoded = Decode(EncodeJpeg(Ramp(type), 95));
    const cv::Mat expected = Ramp(type == CV_8UC3 ? CV_8UC3 : CV_8UC1);
    ASSERT_EQ(decoded.type(), expected.type()) << "type " << type;
    ASSERT_EQ(decoded.size(), expected.size());
    EXPECT_LE(cv::norm(decoded, expected, cv::NORM_INF), 4) << "type " << type;
  }
}

TEST(EncodeJpegTest, BadArgumentsAreNamed) {
  const auto message = [](const cv::Mat& image, int quality) {
    try {
      EncodeJpeg(image, quality);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(message(cv::Mat(), 80), testing::HasSubstr("0 x 0 px"));
  EXPECT_THAT(message(cv::Mat(4, 5, CV_32FC1), 80), testing::HasSubstr("5 x 4 px"));
  EXPECT_THAT(message(cv::Mat(4, 4, CV_8UC2), 80), testing::HasSubstr("2 channels"));
  EXPECT_THAT(message(cv::Mat(4, 4, CV_8UC1), 0), testing::HasSubstr("quality = 0"));
  EXPECT_THAT(message(cv::Mat(4, 4, CV_8UC1), 101), testing::HasSubstr("1 to 100"));
}

}  // namespace
}  // namespace palpate
