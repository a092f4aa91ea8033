// The light ground around a dot, from a ring of pixels that may partly show another object.
#pragma once

#include <array>
#include <cstdint>

namespace palpate {

// A plane of light, level = level0 + gx dx + gy dy, by least squares; dx, dy from the dot's centre
// [px], levels of 255.
struct GroundPlane {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, v = 0, xv = 0, yv = 0, vv = 0;
  double level0 = 0, gx = 0, gy = 0, variance = 0;
  double slope_variance = 0;  // of gx and gy, their mean

  void Add(double dx, double dy, double value) noexcept {
    ++n;
    x += dx, y += dy, v += value;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
    xv += dx * value, yv += dy * value, vv += value * value;
  }
  void Add(const GroundPlane& other) noexcept {
    n += other.n, x += other.x, y += other.y, v += other.v;
    xx += other.xx, xy += other.xy, yy += other.yy;
    xv += other.xv, yv += other.yv, vv += other.vv;
  }
  // False: too few pixels, or all on one side.
  bool Fit() noexcept;
  [[nodiscard]] double At(double dx, double dy) const { return level0 + gx * dx + gy * dy; }
};

// The ring, cut into sectors. Another edge, such as a membrane's clamp, lies in adjacent sectors:
// the plane is that of the longest arc of sectors that one plane explains. A least-squares plane of
// the whole ring would tilt towards the edge, as would a robust one of single pixels, because an
// edge on one side resembles a gradient of light.
class GroundRing {
 public:
  static constexpr int kSectors = 16;

  // Sector of the direction (p, q), counted in the sense of rotation; opposite ones differ by
  // kSectors / 2.
  static int SectorOf(double p, double q) noexcept {
    const double tan_22_5 = 0.41421356237309503;
    const double a = p < 0 ? -p : p, b = q < 0 ? -q : q;
    const int step = static_cast<int>(b > tan_22_5 * a) + static_cast<int>(b > a) +
                     static_cast<int>(tan_22_5 * b > a);
    const int half = p < 0 ? kSectors / 2 - 1 - step : step;
    return q < 0 ? kSectors - 1 - half : half;
  }
  void Add(int sector, double dx, double dy, double value, bool may_be_ground) noexcept {
    Sector& s = sectors_[static_cast<std::size_t>(sector)];
    ++s.seen;
    if (may_be_ground) s.sums.Add(dx, dy, value);
  }
  // False: no arc of more than half the ring is ground.
  bool Fit() noexcept;
  [[nodiscard]] const GroundPlane& plane() const { return plane_; }
  // Returns a bit mask; bit s: sector s or the opposite one is left out.
  [[nodiscard]] std::uint32_t left_out() const { return left_out_; }
  [[nodiscard]] bool LeavesOut(int sector) const { return (left_out_ >> sector & 1U) != 0; }
  // Variance of the sectors' means about the plane, relative to that of independent pixel errors:
  // about 1 for noise, more for light that is not a plane, compression, stripes.
  [[nodiscard]] double unevenness() const noexcept;

 private:
  struct Sector {
    GroundPlane sums;
    int seen = 0;
  };
  [[nodiscard]] const Sector& At(int sector) const {
    return sectors_[static_cast<std::size_t>(sector & (kSectors - 1))];
  }
  [[nodiscard]] double MeanOff(const GroundPlane& sums) const noexcept;
  [[nodiscard]] bool IsGround(const Sector& sector) const noexcept;
  bool FitArc(int first, int count) noexcept;
  void Grow(int first, int count) noexcept;

  std::array<Sector, kSectors> sectors_;
  GroundPlane plane_;
  std::uint32_t left_out_ = 0;
};

}  // namespace palpate
