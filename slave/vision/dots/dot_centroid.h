// From a region of pixels to a dot: is it an ellipse, and where exactly is its middle.
#pragma once

#include <optional>

#include <opencv2/core/mat.hpp>

#include "slave/vision/dots/blob_labeller.h"
#include "slave/vision/dots/dot.h"

namespace palpate {

struct DotShapeLimits {
  double area_min = 30, area_max = 20000;  // [px^2]
  double axes_ratio_min = 0.3;             // short to long axis
  double contrast_min = 20;                // [levels]
};

// An ellipse by its pixels' second moments: its area is 4 pi sqrt(det) of these. nullopt: outside
// `limits`, or not elliptical.
std::optional<Dot> EllipseOf(const Blob& blob, const DotShapeLimits& limits) noexcept;

// The grey-weighted centroid. The ground is a plane fitted to a ring around the dot, so that light
// that changes across the dot does not pull, without the part of the ring in which an edge passes
// by. Each pixel weighs what it differs from the ground, within 2 px of the dot's edge or as far as
// its blur reaches; less far towards that edge and opposite to it. `dot` is what EllipseOf says.
// nullopt: too little contrast, half the ring is not ground, no picture around it, an edge that
// leaves the ellipse by a pixel or more.
std::optional<Dot> RefineDot(const cv::Mat& image, const Dot& dot, int threshold, DotTone tone,
                             const DotShapeLimits& limits) noexcept;

}  // namespace palpate
