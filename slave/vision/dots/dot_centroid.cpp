#include "slave/vision/dots/dot_centroid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Core>

namespace palpate {
namespace {

constexpr double kReach = 2;            // the dot's blurred edge ends within so much of it [px]
constexpr double kRing = 5;             // and the ring of ground here
constexpr double kForeignInRing = 0.2;  // share of the ring that may be something else
constexpr double kRagged = 1;           // an ellipse's edge is nowhere farther off [px]
constexpr double kForeignInDot = 0.01;  // share of the dot's area that may be farther off
constexpr double kSigmaFloor = 0.003;   // what pixels' uneven response leaves [px]

struct Axes {
  double longer = 0, shorter = 0;  // half axes [px]
  double cosine = 1, sine = 0;     // of the longer one
};

Axes AxesOf(const Eigen::Matrix2d& shape) noexcept {
  const double mean = (shape(0, 0) + shape(1, 1)) / 2;
  const double half = (shape(0, 0) - shape(1, 1)) / 2;
  const double deviation = std::hypot(half, shape(0, 1));
  const double angle = std::atan2(shape(0, 1), half) / 2;
  return {2 * std::sqrt(std::max(0.0, mean + deviation)),
          2 * std::sqrt(std::max(0.0, mean - deviation)), std::cos(angle), std::sin(angle)};
}

// { d : d' A d <= 1 }, an ellipse about the origin, cut by rows.
struct Outline {
  double a = 0, b = 0, c = 0;  // A = [a b; b c]
  double height = 0;           // it ends at |dy| = height

  Outline(const Axes& axes, double wider) noexcept {
    const double p = 1 / std::pow(axes.longer + wider, 2);
    const double q = 1 / std::pow(axes.shorter + wider, 2);
    a = p * axes.cosine * axes.cosine + q * axes.sine * axes.sine;
    c = p * axes.sine * axes.sine + q * axes.cosine * axes.cosine;
    b = (p - q) * axes.cosine * axes.sine;
    height = std::sqrt(a / (p * q));
  }
  // The pixels of row `y` inside the ellipse about `centre`: [first, last]; empty: first > last.
  [[nodiscard]] std::array<int, 2> Row(const Eigen::Vector2d& centre, int y, int width) const {
    const double dy = y - centre.y();
    const double root = b * b * dy * dy - a * (c * dy * dy - 1);
    if (root < 0) return {0, -1};
    const double middle = centre.x() - b * dy / a, half = std::sqrt(root) / a;
    return {std::max(0, static_cast<int>(std::ceil(middle - half))),
            std::min(width - 1, static_cast<int>(std::floor(middle + half)))};
  }
};

// level = level0 + gx dx + gy dy, by least squares.
struct Ground {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, v = 0, xv = 0, yv = 0, vv = 0;
  int seen = 0;
  double level0 = 0, gx = 0, gy = 0, variance = 0;
  double slope_variance = 0;  // of gx and gy, their mean

  void Add(double dx, double dy, double value) noexcept {
    ++n;
    x += dx, y += dy, v += value;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
    xv += dx * value, yv += dy * value, vv += value * value;
  }
  // False: too few pixels, or all on one side.
  bool Fit() noexcept {
    if (n < 8 || n < (1 - kForeignInRing) * seen) return false;
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
};

// Light dots are looked at as dark ones of the negative.
struct Negative {
  double sign, offset;
  explicit Negative(DotTone tone) noexcept
      : sign(tone == DotTone::kDark ? 1 : -1), offset(tone == DotTone::kDark ? 0 : 255) {}
  [[nodiscard]] double operator()(double level) const { return offset + sign * level; }
};

struct Window {
  const cv::Mat& image;
  Eigen::Vector2d centre;
  Axes axes;
  Negative level;
  [[nodiscard]] std::array<int, 2> Rows(const Outline& outline) const {
    return {std::max(0, static_cast<int>(std::ceil(centre.y() - outline.height))),
            std::min(image.rows - 1, static_cast<int>(std::floor(centre.y() + outline.height)))};
  }
};

// Also the mean level well inside the dot.
bool FitGround(const Window& w, double threshold, Ground* ground, double* inside) noexcept {
  const Outline outer(w.axes, kRing), edge(w.axes, kReach);
  const Outline core(w.axes, -std::min(2.0, w.axes.shorter / 2));
  double sum = 0, count = 0;
  const auto rows = w.Rows(outer);
  for (int y = rows[0]; y <= rows[1]; ++y) {
    const std::uint8_t* row = w.image.ptr<std::uint8_t>(y);
    const double dy = y - w.centre.y();
    const auto ring = outer.Row(w.centre, y, w.image.cols);
    const auto hole = edge.Row(w.centre, y, w.image.cols);
    const auto add = [&](int first, int last) {
      for (int x = first; x <= last; ++x) {
        const double value = w.level(row[x]);
        ++ground->seen;
        if (value >= threshold) ground->Add(x - w.centre.x(), dy, value);
      }
    };
    if (hole[0] > hole[1]) {
      add(ring[0], ring[1]);
    } else {
      add(ring[0], hole[0] - 1);
      add(hole[1] + 1, ring[1]);
    }
    const auto middle = core.Row(w.centre, y, w.image.cols);
    for (int x = middle[0]; x <= middle[1]; ++x) sum += w.level(row[x]), ++count;
  }
  if (count == 0) return false;
  *inside = sum / count;
  return ground->Fit();
}

}  // namespace

std::optional<Dot> EllipseOf(const Blob& blob, const DotShapeLimits& limits) noexcept {
  const auto n = static_cast<double>(blob.area);
  if (!(n >= limits.area_min && n <= limits.area_max)) return std::nullopt;
  Dot dot;
  dot.area = n;
  dot.centre = Eigen::Vector2d(static_cast<double>(blob.x), static_cast<double>(blob.y)) / n;
  const double square = 1.0 / 12;  // a pixel's own second moment
  dot.shape(0, 0) = static_cast<double>(blob.xx) / n - dot.centre.x() * dot.centre.x() + square;
  dot.shape(1, 1) = static_cast<double>(blob.yy) / n - dot.centre.y() * dot.centre.y() + square;
  dot.shape(0, 1) = static_cast<double>(blob.xy) / n - dot.centre.x() * dot.centre.y();
  dot.shape(1, 0) = dot.shape(0, 1);
  const Axes axes = AxesOf(dot.shape);
  if (!(axes.shorter >= limits.axes_ratio_min * axes.longer)) return std::nullopt;
  // 1 for an ellipse, less for everything else; small ones are blurred by whole pixels.
  const double filled = n / (std::numbers::pi * axes.longer * axes.shorter);
  if (!(filled >= 0.94 - 1 / n && filled <= 1.03 + 1 / n)) return std::nullopt;
  return dot;
}

std::optional<Dot> RefineDot(const cv::Mat& image, const Dot& dot, int threshold, DotTone tone,
                             const DotShapeLimits& limits) noexcept {
  const Window w{image, dot.centre, AxesOf(dot.shape), Negative(tone)};
  Ground ground;
  double inside = 0;
  if (!FitGround(w, w.level(threshold), &ground, &inside)) return std::nullopt;
  const double contrast = ground.level0 - inside;
  if (!(contrast >= limits.contrast_min)) return std::nullopt;
  double sum = 0, sum_x = 0, sum_y = 0, spread = 0, foreign = 0;
  const Outline edge(w.axes, kReach), hull(w.axes, kRagged);
  const Outline core(w.axes, -std::min(kRagged, w.axes.shorter / 2));
  const auto rows = w.Rows(edge);
  for (int y = rows[0]; y <= rows[1]; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    const double dy = y - w.centre.y();
    const auto span = edge.Row(w.centre, y, image.cols);
    const auto dot_span = hull.Row(w.centre, y, image.cols);
    const auto core_span = core.Row(w.centre, y, image.cols);
    for (int x = span[0]; x <= span[1]; ++x) {
      const double dx = x - w.centre.x();
      const double weight =
          std::clamp(ground.level0 + ground.gx * dx + ground.gy * dy - w.level(row[x]),
                     -0.25 * contrast, 1.25 * contrast);
      sum += weight, sum_x += weight * dx, sum_y += weight * dy;
      spread += (dx * dx + dy * dy) / 2;
      const bool is_dot = 2 * weight > contrast;
      const bool may_be_dot = x >= dot_span[0] && x <= dot_span[1];
      const bool must_be_dot = x >= core_span[0] && x <= core_span[1];
      if (is_dot ? !may_be_dot : must_be_dot) ++foreign;
    }
  }
  if (!(sum > 0) || foreign > 1 + kForeignInDot * dot.area) return std::nullopt;
  Dot refined = dot;
  const Eigen::Vector2d moved(sum_x / sum, sum_y / sum);
  if (!(moved.norm() < 1 + 0.1 * w.axes.longer)) return std::nullopt;
  refined.centre += moved;
  refined.contrast = contrast;
  refined.area = sum / contrast;
  const double variance =
      (ground.variance * spread + ground.slope_variance * spread * spread) / (sum * sum);
  refined.sigma = std::sqrt(variance + kSigmaFloor * kSigmaFloor);
  return refined;
}

}  // namespace palpate
