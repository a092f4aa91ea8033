// End and width of the tool in the first image: a check of the encoder reading.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/grey.h"

namespace palpate {

// Size of a tool's end in the image, according to the scene.
struct ToolEndSize {
  double width = 0;   // width of the bar [px]; 0: unknown
  double radius = 0;  // of its end [px]; 0: flat
};
// `pixel`: its size on the tool [m].
ToolEndSize EndSizeOf(const Tool& tool, double pixel);

struct ToolEnd {
  // Distance of the tool's end, or of the apex of a round one, beyond the reported tip, along its
  // direction [px].
  double beyond = 0;
  double aside = 0;  // offset of its axis from the reported tip, towards (-d.y, d.x) [px]
  double width = 0;  // [px]
};

// Detects the end of a bar whose reported end is `p_I_tip` and which points along the unit vector
// `d_I`, in front of a plain background: the median over lines along the bar of the point that is
// half background, beside the axis of a round end by as much as its arc recedes; accurate to some
// tenths of a pixel for marks and blur. nullopt: it does not contrast with its background, has
// another shape, or the end is not within 8 px.
std::optional<ToolEnd> DetectToolEnd(const cv::Mat& first, const GreyFormat& format,
                                     const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& d_I,
                                     const ToolEndSize& tool);

// Returns whether it continues beyond its reported end: its sides are visible 4 to 8 px beyond as
// well. Another object there has another width.
bool ToolGoesOn(const cv::Mat& first, const GreyFormat& format, const Eigen::Vector2d& p_I_tip,
                const Eigen::Vector2d& d_I, const ToolEndSize& tool);

}  // namespace palpate
