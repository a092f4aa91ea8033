// Corresponding places of a rectified pair: windows searched along rows.
//
// For pictures of pairs that were rectified elsewhere and come without a rig, as sets with true
// disparities do; where the rig is known, SearchEpipolar needs no rectification.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate {

struct RowMatchOptions {
  int window = 15;                 // edge [px], odd, 5 to 255
  int least = 0, most = 256;       // disparities searched, left minus right [px]
  double least_correlation = 0.7;  // (0, 1)
  double least_margin = 0.02;      // over the best elsewhere
  double most_side_miss = 1.0;     // of the way back from right to left [px]
};

struct RowMatch {
  bool found = false;
  double disparity = 0;  // x_left - x_right [px]
  double correlation = -1;
};

// One answer per place `at` of the left picture [px]. A match must be the best of its row by a
// margin, from left to right and back. Throws std::invalid_argument: options, pictures that are not
// 8 bit grey or BGR, or not of one size.
std::vector<RowMatch> MatchRows(const cv::Mat& left, const cv::Mat& right,
                                const std::vector<Eigen::Vector2d>& at,
                                const RowMatchOptions& options);

}  // namespace palpate
