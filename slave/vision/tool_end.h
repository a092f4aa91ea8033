// End and width of the tool in the first image: a check of the encoder reading.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"

namespace palpate {

struct ToolEnd {
  double beyond =
      0;             // distance of the tool's end beyond the reported tip, along its direction [px]
  double aside = 0;  // offset of its axis from the reported tip, towards (-d.y, d.x) [px]
  double width = 0;  // [px]
};

// Detects the end of a bar of `width` [px] whose reported end is `p_I_tip` and which points along
// the unit vector `d_I`, in front of a plain background: the median over lines along the bar of the
// point that is half background; accurate to some tenths of a pixel for marks and blur. nullopt: it
// does not contrast with its background, has no blunt end, or the end is not within 8 px.
std::optional<ToolEnd> DetectToolEnd(const cv::Mat& first, const GreyFormat& format,
                                     const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& d_I,
                                     double width);

// Returns whether it continues beyond its reported end: its sides are visible 4 to 8 px beyond as
// well. Another thing there, for example the object, has another width.
bool ToolGoesOn(const cv::Mat& first, const GreyFormat& format, const Eigen::Vector2d& p_I_tip,
                const Eigen::Vector2d& d_I, double width);

}  // namespace palpate
