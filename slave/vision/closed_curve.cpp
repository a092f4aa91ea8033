#include "slave/vision/closed_curve.h"

#include <cmath>

#include "slave/mesh/outline.h"

namespace palpate {
namespace {

// Returns whether segments ab and cd share a point.
bool SegmentsIntersect(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                       const Eigen::Vector2d& d) noexcept {
  const bool apart = (a.cwiseMax(b).array() < c.cwiseMin(d).array()).any() ||
                     (c.cwiseMax(d).array() < a.cwiseMin(b).array()).any();
  if (apart) return false;
  return Cross(b - a, c - a) * Cross(b - a, d - a) <= 0 &&
         Cross(d - c, a - c) * Cross(d - c, b - c) <= 0;
}

}  // namespace

double CurveArea(CurveView curve) noexcept {
  double twice = 0;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    twice += Cross(curve[i], curve[(i + 1) % curve.size()]);
  }
  return 0.5 * twice;
}

double CurveLength(CurveView curve) noexcept {
  double length = 0;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    length += (curve[(i + 1) % curve.size()] - curve[i]).norm();
  }
  return length;
}

bool CrossesItself(CurveView curve) noexcept {
  const std::size_t n = curve.size();
  for (std::size_t i = 0; i + 2 < n; ++i) {
    const std::size_t end = i == 0 ? n - 1 : n;  // the last side is a neighbour of the first
    for (std::size_t j = i + 2; j < end; ++j) {
      if (SegmentsIntersect(curve[i], curve[i + 1], curve[j], curve[(j + 1) % n])) return true;
    }
  }
  return false;
}

Curve Resample(CurveView curve, int count) {
  const double spacing = CurveLength(curve) / count;
  Curve even;
  even.reserve(static_cast<std::size_t>(count));
  double ahead = 0;  // arc length from curve[i] to the next resampled point
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Eigen::Vector2d& a = curve[i];
    const Eigen::Vector2d side = curve[(i + 1) % curve.size()] - a;
    const double length = side.norm();
    for (; ahead < length && even.size() < static_cast<std::size_t>(count); ahead += spacing) {
      even.push_back(a + side * (ahead / length));
    }
    ahead -= length;
  }
  while (even.size() < static_cast<std::size_t>(count)) even.push_back(curve.front());  // rounding
  return even;
}

Curve Smoothed(CurveView curve, int count) {
  constexpr int kFiner = 8;  // samples per spacing
  const Curve fine = Resample(curve, kFiner * count);
  const auto n = static_cast<int>(fine.size());
  Curve smooth;
  smooth.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    Eigen::Vector2d sum(0, 0);
    for (int k = -kFiner / 2; k <= kFiner / 2; ++k) {
      sum += fine[static_cast<std::size_t>((i * kFiner + k + n) % n)];
    }
    smooth.emplace_back(sum / (kFiner + 1));
  }
  return smooth;
}

}  // namespace palpate
