// Dark dots on the inner face of a membrane, as one camera sees them.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "shared/scene/scene.h"
#include "slave/site/stereo/exposure.h"
#include "slave/site/stereo/membrane_view.h"

namespace palpate::site {

// Outlines of the scene's dots at rest, polygons with the area of their circles. Frame O [m].
using DotOutlines = std::vector<std::vector<Eigen::Vector2d>>;
// Throws std::invalid_argument naming the key: a dot that is not wholly on the membrane.
DotOutlines OutlinesOf(const PointTracking& points, const MembraneGeometry& membrane);

class DottedMembrane {
 public:
  static constexpr float kDot = 45;  // grey level

  // `exposure` must outlive this.
  DottedMembrane(const MembraneView& view, const DotOutlines& outlines, const Exposure& exposure);
  // The world as the optics blur it: CV_32F of the lens's size, valid until the next call. Every
  // point of a dot's outline is carried with the membrane; what lies within covers its exact share
  // of each pixel.
  const cv::Mat& Paint(const Dent& dent);

 private:
  MembraneView view_;
  DotOutlines outlines_;
  const Exposure& exposure_;
  cv::Mat ground_;          // CV_32F: blurred, without dots
  cv::Mat seen_, covered_;  // CV_32F
};

}  // namespace palpate::site
