#include "slave/vision/dots/ground_ring.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Largest fraction of a ring or sector that may be darker than the background.
constexpr double kForeign = 0.2;
// Sectors of an arc to start from. [-] [tuned: AnEdgeBesideADotDoesNotPullItInNoise]
constexpr int kMinArc = 9;
constexpr int kStep = 2;  // sectors from one start to the next
// Ratio of the variance of a whole ring to that of its quietest arc that may occur by chance [-].
// [tuned: CorrelatedNoiseOfNeighboursIsDetected]
constexpr double kNoisier = 1.5;
constexpr double kUnlike = 3;      // largest difference of sectors' means [sigma]
constexpr double kUneven = 3;      // largest ratio of a sector's variance to the arc's
constexpr double kRounding = 0.3;  // [levels] [derived: whole numbers, 0.29 rms]

}  // namespace

bool GroundPlane::Fit() noexcept {
  if (n < 8) return false;
  const double cxx = xx - x * x / n, cxy = xy - x * y / n, cyy = yy - y * y / n;
  const double cxv = xv - x * v / n, cyv = yv - y * v / n;
  const double determinant = cxx * cyy - cxy * cxy;
  if (!(determinant > 0.1 * cxx * cyy)) return false;
  gx = (cyy * cxv - cxy * cyv) / determinant;
  gy = (cxx * cyv - cxy * cxv) / determinant;
  level0 = (v - gx * x - gy * y) / n;
  variance = std::max(0.0, vv - v * v / n - gx * cxv - gy * cyv) / std::max(1.0, n - 3);
  slope_variance = variance * (cxx + cyy) / (2 * determinant);
  return true;
}

bool GroundRing::Fit() noexcept {
  left_out_ = 0;
  int quietest = -1;
  double variance = 0;
  for (int first = 0; first < kSectors; first += kStep) {
    if (!FitArc(first, kMinArc) || (quietest >= 0 && plane_.variance >= variance)) continue;
    quietest = first;
    variance = plane_.variance;
  }
  if (quietest < 0) return false;
  if (FitArc(0, kSectors) && plane_.variance < kNoisier * variance + kRounding * kRounding) {
    return true;
  }
  Grow(quietest, kMinArc);
  return true;
}

bool GroundRing::FitArc(int first, int count) noexcept {
  GroundPlane plane;
  int seen = 0;
  for (int s = first; s < first + count; ++s) {
    plane.Add(At(s).sums);
    seen += At(s).seen;
  }
  const bool fits = plane.n >= (1 - kForeign) * seen && plane.Fit();
  plane_ = plane;
  return fits;
}

// Extends the arc at both ends while the next sector fits the plane.
void GroundRing::Grow(int first, int count) noexcept {
  FitArc(first, count);
  for (bool grown = true; grown && count < kSectors;) {
    grown = false;
    for (const bool back : {true, false}) {
      if (count == kSectors || !IsGround(At(back ? first - 1 : first + count))) continue;
      if (back) --first;
      ++count;
      grown = FitArc(first, count);
    }
  }
  for (int s = first + count; s < first + kSectors; ++s) {
    left_out_ |= 1U << (s & (kSectors - 1));
    left_out_ |= 1U << ((s + kSectors / 2) & (kSectors - 1));
  }
}

// A sector outside the image is not background, and nothing is hidden in it.
bool GroundRing::IsGround(const Sector& sector) const noexcept {
  if (sector.seen == 0) return true;
  const GroundPlane& s = sector.sums;
  if (s.n < (1 - kForeign) * sector.seen) return false;
  const double level0 = plane_.level0, gx = plane_.gx, gy = plane_.gy;
  const double off = MeanOff(s);
  const double squares = s.vv + level0 * level0 * s.n + gx * gx * s.xx + gy * gy * s.yy +
                         2 * (level0 * gx * s.x + level0 * gy * s.y + gx * gy * s.xy) -
                         2 * (level0 * s.v + gx * s.xv + gy * s.yv);
  // The extrapolated plane is itself uncertain.
  const double reach = (s.xx + s.yy) / s.n;
  const double mean_variance =
      plane_.variance * (1 / s.n + 1 / plane_.n) + plane_.slope_variance * reach;
  return std::abs(off) < kUnlike * std::sqrt(mean_variance) + kRounding &&
         squares / s.n < kUneven * plane_.variance + off * off + kRounding;
}

// Returns the mean deviation of the pixels from the plane [levels].
double GroundRing::MeanOff(const GroundPlane& sums) const noexcept {
  return (sums.v - plane_.level0 * sums.n - plane_.gx * sums.x - plane_.gy * sums.y) / sums.n;
}

double GroundRing::unevenness() const noexcept {
  constexpr int kPlane = 3;  // parameters of a plane [by definition]
  double square = 0;
  int count = 0;
  for (int s = 0; s < kSectors; ++s) {
    const GroundPlane& sums = At(s).sums;
    if (sums.n < 1 || LeavesOut(s)) continue;
    square += sums.n * std::pow(MeanOff(sums), 2);
    ++count;
  }
  const double expected = plane_.variance + kRounding * kRounding;
  return count > kPlane ? square / (expected * (count - kPlane)) : 1;
}

}  // namespace palpate
