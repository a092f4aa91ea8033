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

// For a bar of `width` [px] whose reported end is `p_I_tip` and which points along the unit vector
// `d_I`, in front of a plain background: the median over lines along the bar of the point that is
// half background; accurate to some tenths of a pixel for marks and blur. nullopt: it does not
// contrast with its background, has no blunt end, or the end is not within 8 px.
std::optional<ToolEnd> DetectToolEnd(const cv::Mat& first, const GreyFormat& format,
                                     const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& d_I,
                                     double width);

struct FoundTool {
  Eigen::Vector2d p_I_tip{0, 0},
      d_I{0, 0};     // end on its axis [px]; unit vector along which it points
  double width = 0;  // [px]
};

// A tool near `p_I_tip` (8 px), about `width` [px] wide (a third), that points to `towards_I` [px]
// (60 degrees), as DetectToolEnd measures it. nullopt: as there.
std::optional<FoundTool> FindTool(const cv::Mat& image, const Eigen::Vector2d& p_I_tip,
                                  double width, const Eigen::Vector2d& towards_I);

// Whether it continues beyond its reported end: its sides are visible 4 to 8 px beyond as well.
// Another thing there, for example the object, has another width.
bool ToolGoesOn(const cv::Mat& first, const GreyFormat& format, const Eigen::Vector2d& p_I_tip,
                const Eigen::Vector2d& d_I, double width);

}  // namespace palpate
