// How much of each pixel a polygon covers, exactly: the way font rasterisers do it, with signed
// areas accumulated along rows. A straight edge is thereby drawn where it is, not to a raster.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace palpate::site {

// Coverage of a window of the picture.
class Coverage {
 public:
  // `window`: the part of the picture looked at [px].
  explicit Coverage(const cv::Rect& window);
  // Adds a closed polygon [px], pixel centres at integers. Loops turning the other way are holes.
  // Parts outside the window are cut off.
  void Add(const std::vector<Eigen::Vector2d>& polygon);
  // Writes 0 to 1 into `alpha` (CV_32F, the window's size).
  void Resolve(cv::Mat& alpha) const;

 private:
  void AddEdge(const Eigen::Vector2d& a, const Eigen::Vector2d& b);
  void AddRowPiece(int row, double x0, double y0, double x1, double y1);

  cv::Rect window_;
  int stride_;
  std::vector<float> change_;  // per row: change of coverage from one pixel to the next
};

// Smallest window of whole pixels around `polygon`, grown by `margin` and cut to `size`.
cv::Rect WindowAround(const std::vector<Eigen::Vector2d>& polygon, int margin,
                      const cv::Size& size);

}  // namespace palpate::site
