#include "slave/vision/dots/dot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include "slave/vision/dots/ground_ring.h"

namespace palpate {
namespace {

constexpr double kReach = 2;     // distance within which a sharp dot's edge ends [px]
constexpr double kMaxReach = 8;  // and a blurred one's [px]
// The reach of a blurred edge, in sigma of its blur [-]. [tuned: BlurDoesNotMoveADot]
constexpr double kReachInBlurs = 2.65;
constexpr double kWider = 0.3;  // growth of the reach for which the dot is measured again [px]
// Width of the background ring around it [px]. [tuned: LightThatFallsAcrossTheImageLosesNoDot]
constexpr double kRing = 3;
// Distance to a nearby edge within which pixel weights decrease to zero [px]. [tuned:
// AnEdgeBesideADotDoesNotPullItInNoise]
constexpr double kFade = 1.4;
// Largest deviation of a dot's edge from an ellipse [px]. [tuned:
// EvenlyFallingLightDoesNotPullADot]
constexpr double kRagged = 1;
constexpr double kForeignInDot = 0.01;  // share of the dot's area that may deviate more
// Number of measurements, each with the reach for the blur found by the previous one.
constexpr int kLooks = 3;
constexpr int kWindowRounds = 3;       // iterations for a window that cuts the dot's edge
constexpr double kSigmaFloor = 0.003;  // error by the uneven response of pixels [px]

struct Axes {
  double longer = 0, shorter = 0;  // half axes [px]
  double cosine = 1, sine = 0;     // direction of the longer axis
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
struct Ellipse {
  double a = 0, b = 0, c = 0;  // A = [a b; b c]
  double height = 0;           // half height of the ellipse

  Ellipse(const Axes& axes, double wider) noexcept {
    const double p = 1 / std::pow(axes.longer + wider, 2);
    const double q = 1 / std::pow(axes.shorter + wider, 2);
    a = p * axes.cosine * axes.cosine + q * axes.sine * axes.sine;
    c = p * axes.sine * axes.sine + q * axes.cosine * axes.cosine;
    b = (p - q) * axes.cosine * axes.sine;
    height = std::sqrt(a / (p * q));
  }
  // Returns the distance of a pixel beyond the ellipse along the ray from the centre [px].
  [[nodiscard]] double Beyond(double dx, double dy) const {
    const double stretch = std::sqrt(a * dx * dx + 2 * b * dx * dy + c * dy * dy);
    return std::hypot(dx, dy) * (1 - 1 / stretch);
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

// Light dots are measured as dark dots in the negative image.
struct Negative {
  double sign, offset;
  explicit Negative(DotTone tone) noexcept
      : sign(tone == DotTone::kDark ? 1 : -1), offset(tone == DotTone::kDark ? 0 : 255) {}
  [[nodiscard]] double operator()(double level) const { return offset + sign * level; }
  // Scales a dark dot's difference from the background to the background level at `middle`, because
  // illumination scales both. Light dots may have a black background, so they are not scaled.
  [[nodiscard]] double Evenly(double difference, double ground, double middle) const {
    return sign > 0 && 2 * ground > middle ? difference * middle / ground : difference;
  }
};

struct Window {
  const cv::Mat& image;
  Eigen::Vector2d centre;
  Axes axes;
  Negative level;
  double reach;  // of the dot's blurred edge [px]
  [[nodiscard]] std::array<int, 2> Rows(const Ellipse& outline) const {
    return {std::max(0, static_cast<int>(std::ceil(centre.y() - outline.height))),
            std::min(image.rows - 1, static_cast<int>(std::floor(centre.y() + outline.height)))};
  }
};

// Directions from the centre, after the transformation that maps a ring around the dot to a circle.
struct Directions {
  double pp, pq, qp, qq;
  Directions(const Axes& axes, double reach) noexcept {
    const double along = 1 / (axes.longer + reach + kRing / 2);
    const double across = 1 / (axes.shorter + reach + kRing / 2);
    pp = axes.cosine * along, pq = axes.sine * along;
    qp = -axes.sine * across, qq = axes.cosine * across;
  }
  [[nodiscard]] int SectorOf(double dx, double dy) const noexcept {
    return GroundRing::SectorOf(pp * dx + pq * dy, qp * dx + qq * dy);
  }
};

// Also computes the mean grey level well inside the dot.
bool FitGround(const Window& w, double threshold, GroundRing* ground, double* inside) noexcept {
  const Ellipse outer(w.axes, w.reach + kRing), edge(w.axes, w.reach);
  const Ellipse core(w.axes, -std::min(2.0, w.axes.shorter / 2));
  const Directions directions(w.axes, w.reach);
  double sum = 0, count = 0;
  const auto rows = w.Rows(outer);
  for (int y = rows[0]; y <= rows[1]; ++y) {
    const std::uint8_t* row = w.image.ptr<std::uint8_t>(y);
    const double dy = y - w.centre.y();
    const auto ring = outer.Row(w.centre, y, w.image.cols);
    const auto hole = edge.Row(w.centre, y, w.image.cols);
    const auto add = [&](int first, int last) {
      for (int x = first; x <= last; ++x) {
        const double dx = x - w.centre.x(), value = w.level(row[x]);
        ground->Add(directions.SectorOf(dx, dy), dx, dy, value, value >= threshold);
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

// Weighed holds the differences of the pixels within the dot's reach from the ground: their sum,
// and moments about w.centre.
struct Weighed {
  double sum = 0, x = 0, y = 0;
  double spread = 0;  // second moment of the pixels
  int foreign = 0;    // dark pixels outside of the dot, or bright ones inside
  int edge = 0;       // pixels between dot and background, where the ring is background
};

// In sectors whose ring is not background the radius is reduced, and in the opposite sectors as
// well, so that the blurred edge is cut symmetrically. The cut is soft, because whole pixels would
// cause steps.
Weighed Weigh(const Window& w, const Eigen::Vector2d& middle, const GroundRing& ring,
              double contrast) noexcept {
  const Ellipse edge(w.axes, w.reach), hull(w.axes, kRagged), beside(w.axes, 0);
  const Ellipse core(w.axes, -std::min(kRagged, w.axes.shorter / 2));
  const Directions directions(w.axes, w.reach);
  const GroundPlane& ground = ring.plane();
  Weighed weighed;
  const int top = std::max(0, static_cast<int>(std::ceil(middle.y() - edge.height)));
  const int bottom =
      std::min(w.image.rows - 1, static_cast<int>(std::floor(middle.y() + edge.height)));
  for (int y = top; y <= bottom; ++y) {
    const std::uint8_t* row = w.image.ptr<std::uint8_t>(y);
    const double dy = y - w.centre.y();
    const auto span = edge.Row(middle, y, w.image.cols);
    const auto dot_span = hull.Row(middle, y, w.image.cols);
    const auto core_span = core.Row(middle, y, w.image.cols);
    const auto near_span = ring.left_out() == 0 ? span : beside.Row(middle, y, w.image.cols);
    for (int x = span[0]; x <= span[1]; ++x) {
      const double dx = x - w.centre.x();
      double share = 1;
      if (x < near_span[0] || x > near_span[1]) {
        const Eigen::Vector2d d(x - middle.x(), y - middle.y());
        if (ring.LeavesOut(directions.SectorOf(d.x(), d.y()))) {
          share = 1 - beside.Beyond(d.x(), d.y()) / kFade;
          if (share <= 0) continue;
        }
      }
      const double light = ground.At(dx, dy);
      const double weight =
          std::clamp(w.level.Evenly(light - w.level(row[x]), light, ground.level0),
                     -0.25 * contrast, 1.25 * contrast);
      weighed.sum += share * weight;
      weighed.x += share * weight * dx, weighed.y += share * weight * dy;
      weighed.spread += share * (dx * dx + dy * dy) / 2;
      const bool is_dot = 2 * weight > contrast;
      const bool may_be_dot = x >= dot_span[0] && x <= dot_span[1];
      const bool must_be_dot = x >= core_span[0] && x <= core_span[1];
      weighed.foreign += static_cast<int>(is_dot ? !may_be_dot : must_be_dot);
      weighed.edge += static_cast<int>(std::abs(2 * weight - contrast) < 0.5 * contrast);
    }
  }
  return weighed;
}

struct MeasuredDot {
  Dot dot;
  double blur = 0;  // sigma [px]
};

std::optional<MeasuredDot> MeasureWithin(const Window& w, const Dot& dot, double threshold,
                                         const DotShapeLimits& limits) noexcept {
  GroundRing ring;
  double inside = 0;
  if (!FitGround(w, threshold, &ring, &inside)) return std::nullopt;
  const GroundPlane& ground = ring.plane();
  const double contrast = ground.level0 - inside;
  if (!(contrast >= limits.contrast_min)) return std::nullopt;
  Weighed weighed;
  Eigen::Vector2d moved(0, 0);
  // A window that cuts the blurred edge must be centred on the resulting centre.
  const int rounds = ring.left_out() == 0 ? 1 : kWindowRounds;
  for (int k = 0; k < rounds; ++k) {
    weighed = Weigh(w, w.centre + moved, ring, contrast);
    if (!(weighed.sum > 0)) return std::nullopt;
    moved = Eigen::Vector2d(weighed.x, weighed.y) / weighed.sum;
    if (!(moved.norm() < 1 + 0.1 * w.axes.longer)) return std::nullopt;
  }
  if (weighed.foreign > 1 + kForeignInDot * dot.area) return std::nullopt;
  MeasuredDot region{dot};
  region.dot.centre += moved;
  region.dot.area = weighed.sum / contrast;
  // Correlated errors of neighbouring pixels do not average out.
  const double variance =
      std::max(1.0, ring.unevenness()) *
      (ground.variance * weighed.spread + ground.slope_variance * weighed.spread * weighed.spread) /
      (weighed.sum * weighed.sum);
  region.dot.sigma = std::sqrt(variance + kSigmaFloor * kSigmaFloor);
  // A blurred edge passes from one to three quarters within 1.349 sigma.
  const double perimeter = std::numbers::pi * (w.axes.longer + w.axes.shorter);
  region.blur = weighed.edge / (1.349 * perimeter);
  return region;
}

}  // namespace

std::optional<Dot> EllipseOf(const cv::Moments& region, const cv::Point& origin,
                             const DotShapeLimits& limits) noexcept {
  const double n = region.m00;
  if (!(n >= limits.area_min && n <= limits.area_max)) return std::nullopt;
  Dot dot;
  dot.area = n;
  dot.centre = Eigen::Vector2d(origin.x + region.m10 / n, origin.y + region.m01 / n);
  const double square = 1.0 / 12;  // a pixel's own second moment
  dot.shape << region.mu20 / n + square, region.mu11 / n, region.mu11 / n, region.mu02 / n + square;
  const Axes axes = AxesOf(dot.shape);
  if (!(axes.shorter >= limits.axes_ratio_min * axes.longer)) return std::nullopt;
  // 1 for an ellipse, less for other shapes; small dots are blurred by the pixels.
  const double filled = n / (std::numbers::pi * axes.longer * axes.shorter);
  if (!(filled >= 0.94 - 1 / n && filled <= 1.03 + 1 / n)) return std::nullopt;
  return dot;
}

std::optional<Dot> RefineDot(const cv::Mat& image, const Dot& dot, int threshold, DotTone tone,
                             const DotShapeLimits& limits) noexcept {
  Window w{image, dot.centre, AxesOf(dot.shape), Negative(tone), kReach};
  std::optional<Dot> refined;
  for (int k = 0; k < kLooks; ++k) {
    const auto region = MeasureWithin(w, dot, w.level(threshold), limits);
    if (!region) break;
    refined = region->dot;
    const double reach = std::min(kReachInBlurs * region->blur, kMaxReach);
    if (reach < w.reach + kWider) break;
    w.reach = reach;
  }
  return refined;
}

}  // namespace palpate
