// Dark dots on the inner face of a membrane, as one camera sees them.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/site/exposure.h"
#include "slave/site/points/membrane_view.h"

namespace palpate::site {

// Frame O.
struct PrintedDots {
  std::vector<Eigen::Vector2d> places_O;  // at rest [m]
  double radius = 0;                      // [m]
};
// Throws std::invalid_argument naming the key: a dot that is not wholly on the membrane.
PrintedDots DotsOn(const MembraneGeometry& membrane, const PointTracking& points);

class DottedMembrane {
 public:
  static constexpr float kDot = 45;  // grey level

  // `exposure` must outlive this.
  DottedMembrane(const MembraneView& view, const PrintedDots& dots, const Exposure& exposure);
  // The world as the optics blur it: CV_32F of the lens's size, valid until the next call. Dots
  // are small stiff discs: each moves with the membrane's point in its middle and tilts as the
  // surface does there, and covers its exact share of each pixel. (Ink that bends with the rubber
  // would show the mean of the surface under it: under the middle of a tool as wide as the dots,
  // 5 mm deep, 0.2 mm less than the point in the dot's middle, elsewhere hundredths.)
  const cv::Mat& Paint(const Dent& dent);

 private:
  // Corners of the outline of the disc at p_O in the picture [px]; false: not all are seen.
  bool Outline(const Eigen::Vector2d& p_O, const Dent& dent,
               std::vector<Eigen::Vector2d>* outline) const;

  MembraneView view_;
  PrintedDots dots_;
  const Exposure& exposure_;
  cv::Mat ground_;          // CV_32F: blurred, without dots
  cv::Mat seen_, covered_;  // CV_32F
};

}  // namespace palpate::site
