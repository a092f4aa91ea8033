// What the tool's tip looks like, and where in that small picture the tip is.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/grey.h"

namespace palpate {

struct TipTemplate {
  GreyPatch pixels;
  // The tip, from the upper left pixel's centre [px]; may lie outside.
  Eigen::Vector2d anchor{0, 0};
  // Per pixel: how far the fine alignment trusts it, 0 or 1.
  std::vector<float> weights;
};

// Reads the scene's template file. Without an anchor, the tip is in the middle of its lower edge.
// Throws std::runtime_error naming the key and the file: unreadable, too small (below 5 px), too
// large (above 512 px), without contrast.
TipTemplate LoadTipTemplate(const TipTracking& options);

// Cuts the template from the picture `first`: the tool is a bar of `width` [px] whose end is at
// `p_I_tip`, pointing along the unit vector `d_I` (both in I).
//
// The window shows the tool and a little of the background on either side, but nothing beyond the
// tip: there the object will be, and deform. It needs marks (or a taper) on the tool: where there
// are none, a few pixels beyond the tip are taken in, for otherwise nothing tells where along
// itself the tool is. Background beside the tool's end gets no weight: the dented object rises
// there. A window is upright, so for an oblique tool it ends somewhat before the tip.
// Throws std::runtime_error: the tip or too much of the tool lies outside the picture, no contrast.
TipTemplate CutTipTemplate(const cv::Mat& first, const GreyFormat& format,
                           const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& d_I, double width,
                           int roi);

}  // namespace palpate
