// Closed polygons in the image: the last point joins the first.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace palpate {

using Curve = std::vector<Eigen::Vector2d>;
using CurveView = std::span<const Eigen::Vector2d>;

// Signed area [px^2]: positive if counter-clockwise in axes x right, y up, that is clockwise in an
// image with y down.
double CurveArea(CurveView curve) noexcept;
// Perimeter [px].
double CurveLength(CurveView curve) noexcept;
// Two sides that are not neighbours cross or touch. O(n^2).
bool CrossesItself(CurveView curve) noexcept;
// `count` points at equal arc length from the first point on. `curve` has a length > 0.
Curve Resample(CurveView curve, int count);
// `count` points like Resample, each the mean of the curve within half a spacing before and behind
// it: jitter of single points averages out, features shorter than a spacing are rounded. For
// outlines found in images.
Curve Smoothed(CurveView curve, int count);

}  // namespace palpate
