#include "slave/vision/texture/good_windows.h"

#include <opencv2/imgproc.hpp>

namespace palpate {

std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& picture, int count, int edge,
                                           double apart) {
  const bool readable =
      picture.dims == 2 && (picture.type() == CV_8UC1 || picture.type() == CV_8UC3);
  const int rim = edge / 2 + 2;
  if (!readable || count < 1 || edge < 1 || picture.cols <= 2 * rim || picture.rows <= 2 * rim) {
    return {};
  }
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::Mat inside = cv::Mat::zeros(grey.size(), CV_8UC1);
  inside(cv::Rect(rim, rim, grey.cols - 2 * rim, grey.rows - 2 * rim)).setTo(255);
  constexpr double kOfTheBest = 0.01;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(grey, corners, count, kOfTheBest, apart, inside, edge);
  std::vector<Eigen::Vector2d> centres;
  centres.reserve(corners.size());
  for (const cv::Point2f& corner : corners) centres.emplace_back(corner.x, corner.y);
  return centres;
}

}  // namespace palpate
