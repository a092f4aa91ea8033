// The tool's end and width as the first picture shows them: a witness of where the manipulator says
// that the tip is.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"

namespace palpate {

struct ToolEnd {
  double beyond = 0;  // how far past the told tip the tool ends, along its direction [px]
  double aside = 0;   // how far beside the told tip its axis runs, towards (-d.y, d.x) [px]
  double width = 0;   // [px]
};

// Of a bar of `width` [px] that is told to end at `p_I_tip` and points along the unit vector `d_I`,
// before a ground that is plain beside it: where along lines from inside outwards it is half
// ground, the median of the lines; right to some tenths of a pixel for marks and blur. nullopt: it
// does not stand out of its ground all along, has no blunt end, or that is not within 8 px.
std::optional<ToolEnd> DetectToolEnd(const cv::Mat& first, const GreyFormat& format,
                                     const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& d_I,
                                     double width);

// Whether it goes on past where it is told to end: its sides are seen 4 to 8 px past that, too.
// What else begins there, the object say, is not as wide.
bool ToolGoesOn(const cv::Mat& first, const GreyFormat& format, const Eigen::Vector2d& p_I_tip,
                const Eigen::Vector2d& d_I, double width);

}  // namespace palpate
