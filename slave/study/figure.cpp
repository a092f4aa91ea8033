#include "slave/study/figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "slave/study/svg.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Points = std::vector<Vector2d>;

constexpr double kWidth = 860, kHeight = 520;
constexpr double kLeft = 74, kRight = 640, kTop = 56, kBottom = 462;
constexpr double kSmallestError = 1e-8;  // below it nothing is drawn to scale

constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 12px; }
.paper { fill: #ffffff; }
.ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 16px; font-weight: 600; } .small { font-size: 11px; }
.grid { stroke: #d9dee6; stroke-width: 1; } .frame { fill: none; stroke: #8a94a6; }
.target { fill: #2f9e62; fill-opacity: 0.12; stroke: #2f9e62; stroke-dasharray: 4 3; }
.front { fill: none; stroke: #5b6576; stroke-width: 1.5; stroke-dasharray: 7 3; }
.choice { fill: none; stroke: #d6336c; stroke-width: 2; } .choice-ink { fill: #d6336c; }
.mark { stroke-width: 1.5; fill-opacity: 0.75; } .bar { stroke-width: 1.2; fill: none; }
.c0 { fill: #2f6fd6; stroke: #2f6fd6; } .c1 { fill: #e0701c; stroke: #e0701c; }
.c2 { fill: #2f9e62; stroke: #2f9e62; } .c3 { fill: #a64fc9; stroke: #a64fc9; }
.c4 { fill: #c98a00; stroke: #c98a00; } .c5 { fill: #149aa8; stroke: #149aa8; }
.c6 { fill: #d14545; stroke: #d14545; } .c7 { fill: #76808f; stroke: #76808f; }
@media (prefers-color-scheme: dark) {
.paper { fill: #14181f; } .ink { fill: #e8ecf2; } .soft { fill: #a9b3c2; }
.grid { stroke: #2a313c; } .frame { stroke: #6b7586; } .front { stroke: #a9b3c2; }
.choice { stroke: #ff6b9a; } .choice-ink { fill: #ff6b9a; }
.c0 { fill: #6ea4ff; stroke: #6ea4ff; } .c1 { fill: #ff9a4d; stroke: #ff9a4d; }
.c2 { fill: #58c98c; stroke: #58c98c; } .c3 { fill: #cd85ec; stroke: #cd85ec; }
.c4 { fill: #ecb53a; stroke: #ecb53a; } .c5 { fill: #4cc4d1; stroke: #4cc4d1; }
.c6 { fill: #f07676; stroke: #f07676; } .c7 { fill: #a2acba; stroke: #a2acba; }
}
)";
constexpr std::size_t kColours = 8;

bool IsDrawn(const Row& row) {
  return row.outcome == Outcome::kAnswered && std::isfinite(row.error.value) &&
         row.update_median_s > 0;
}

// Whole decades around the values, at least two.
struct Decades {
  int low = 0, high = 0;
  static Decades Around(const std::vector<double>& values) {
    const auto [least, most] = std::ranges::minmax(values);
    Decades d{static_cast<int>(std::floor(std::log10(least))),
              static_cast<int>(std::ceil(std::log10(most)))};
    while (d.high - d.low < 2) ++d.high;
    return d;
  }
  [[nodiscard]] double Share(double value) const {
    return std::clamp((std::log10(value) - low) / (high - low), 0.0, 1.0);
  }
};

std::string PowerOfTen(int exponent, std::string_view unit) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", std::pow(10, exponent));
  return std::string(text) + (unit.empty() ? "" : " ") + std::string(unit);
}

// Seconds with a readable unit, for whole decades.
std::string Seconds(int exponent) {
  if (exponent >= 0) return PowerOfTen(exponent, "s");
  if (exponent >= -3) return PowerOfTen(exponent + 3, "ms");
  if (exponent >= -6) return PowerOfTen(exponent + 6, "us");
  return PowerOfTen(exponent + 9, "ns");
}

Points Star(const Vector2d& at, int corners, double radius, double inner, double turn) {
  Points points;
  const int count = inner < 1 ? 2 * corners : corners;
  for (int i = 0; i < count; ++i) {
    const double angle = turn + 2 * std::numbers::pi * i / count;
    const double r = radius * (inner < 1 && i % 2 == 1 ? inner : 1);
    points.emplace_back(at + r * Vector2d(std::sin(angle), -std::cos(angle)));
  }
  return points;
}

void Mark(Svg* svg, std::size_t family, const Vector2d& at, std::string_view tooltip) {
  const std::string style = "mark c" + std::to_string(family % kColours);
  constexpr double kQuarter = std::numbers::pi / 4;
  switch (family % 6) {
    case 0:
      return svg->Circle(at, 5, style, tooltip);
    case 1:
      return svg->Polygon(Star(at, 4, 6.4, 1, kQuarter), style, tooltip);
    case 2:
      return svg->Polygon(Star(at, 3, 6.6, 1, 0), style, tooltip);
    case 3:
      return svg->Polygon(Star(at, 4, 6.4, 1, 0), style, tooltip);
    case 4:
      return svg->Polygon(Star(at, 3, 6.6, 1, std::numbers::pi), style, tooltip);
    default:
      return svg->Polygon(Star(at, 5, 7.4, 0.45, 0), style, tooltip);
  }
}

std::string Tooltip(const Row& row) {
  char text[160];
  std::snprintf(
      text, sizeof text, ": error %.3g %% (+- %.2g %%), update %.3g us, precompute %.3g s",
      100 * row.error.value, 100 * row.error.bar, 1e6 * row.update_median_s, row.precompute_s);
  return row.family + ", " + row.resolution + text;
}

class Figure {
 public:
  explicit Figure(const StudyResult& study)
      : study_(study),
        svg_(kWidth, kHeight, "Speed against accuracy: " + study.scene_name, kStyle) {
    std::vector<double> times{1 / study.rate}, errors{study.tolerance};
    for (const Row& row : study.rows) {
      if (!IsDrawn(row)) continue;
      drawn_.push_back(&row);
      times.push_back(row.update_median_s);
      errors.push_back(std::max(row.error.value, kSmallestError));
      if (std::ranges::find(families_, row.family) == families_.end()) {
        families_.push_back(row.family);
      }
    }
    std::ranges::sort(families_);
    x_ = Decades::Around(times);
    y_ = Decades::Around(errors);
  }

  std::string Draw() {
    svg_.Rectangle({0, 0}, {kWidth, kHeight}, "paper");
    DrawAxes();
    DrawTarget();
    DrawFront();
    for (const Row* row : drawn_) DrawRow(*row);
    DrawLegend();
    return svg_.Document();
  }

 private:
  [[nodiscard]] double X(double seconds) const {
    return kLeft + (kRight - kLeft) * x_.Share(seconds);
  }
  [[nodiscard]] double Y(double error) const {
    return kBottom - (kBottom - kTop) * y_.Share(std::max(error, kSmallestError));
  }
  [[nodiscard]] Vector2d At(const Row& row) const {
    return {X(row.update_median_s), Y(row.error.value)};
  }

  void DrawAxes() {
    svg_.Text({kLeft, 26}, study_.scene_name + ": what speed costs in accuracy", "ink heading");
    svg_.Text({kLeft, 44}, study_.recommendation, "soft small");
    for (int d = x_.low; d <= x_.high; ++d) {
      const double x = X(std::pow(10, d));
      svg_.Line({x, kTop}, {x, kBottom}, "grid");
      svg_.Text({x, kBottom + 18}, Seconds(d), "soft", Svg::Anchor::kMiddle);
    }
    for (int d = y_.low; d <= y_.high; ++d) {
      const double y = Y(std::pow(10, d));
      svg_.Line({kLeft, y}, {kRight, y}, "grid");
      svg_.Text({kLeft - 8, y + 4}, PowerOfTen(d + 2, "%"), "soft", Svg::Anchor::kEnd);
    }
    svg_.Rectangle({kLeft, kTop}, {kRight - kLeft, kBottom - kTop}, "frame");
    svg_.Text({0.5 * (kLeft + kRight), kBottom + 40}, "update of a moved contact (median)", "ink",
              Svg::Anchor::kMiddle);
    svg_.Text({18, 0.5 * (kTop + kBottom)}, "error of the contact force", "ink",
              Svg::Anchor::kMiddle, -90);
  }

  void DrawTarget() {
    const Vector2d corner(kLeft, Y(study_.tolerance));
    const Vector2d size = Vector2d(X(1 / study_.rate), kBottom) - corner;
    svg_.Rectangle(corner, size, "target");
    char words[80];
    std::snprintf(words, sizeof words, "asked for: %g %% at %g Hz", 100 * study_.tolerance,
                  study_.rate);
    svg_.Text({kLeft + 8, kBottom - 8}, words, "soft small");
  }

  // A staircase: what is reachable lies above and to the right of it.
  void DrawFront() {
    std::vector<const Row*> front;
    for (const Row* row : drawn_) {
      if (row->on_front) front.push_back(row);
    }
    std::ranges::sort(front, {}, [](const Row* row) { return row->update_median_s; });
    Points points;
    for (const Row* row : front) {
      const Vector2d at = At(*row);
      if (!points.empty()) points.emplace_back(at.x(), points.back().y());
      points.push_back(at);
    }
    if (points.size() > 1) svg_.Polyline(points, "front");
  }

  void DrawRow(const Row& row) {
    const auto family =
        static_cast<std::size_t>(std::ranges::find(families_, row.family) - families_.begin());
    const Vector2d at = At(row);
    const std::string bar = "bar c" + std::to_string(family % kColours);
    svg_.Line({at.x(), Y(row.error.value + row.error.bar)},
              {at.x(), Y(row.error.value - row.error.bar)}, bar);
    Mark(&svg_, family, at, Tooltip(row));
    if (!row.recommended) return;
    svg_.Circle(at, 11, "choice");
    const bool right = at.x() < 0.5 * (kLeft + kRight);
    svg_.Text(at + Vector2d(right ? 16 : -16, -10), "recommended: " + row.resolution,
              "choice-ink small", right ? Svg::Anchor::kStart : Svg::Anchor::kEnd);
  }

  void DrawLegend() {
    double y = kTop + 10;
    for (std::size_t f = 0; f < families_.size(); ++f, y += 22) {
      Mark(&svg_, f, {kRight + 26, y}, {});
      svg_.Text({kRight + 40, y + 4}, families_[f], "ink");
    }
    svg_.Line({kRight + 16, y}, {kRight + 36, y}, "front");
    svg_.Text({kRight + 40, y + 4}, "nothing beats these", "soft");
  }

  const StudyResult& study_;
  Svg svg_;
  std::vector<const Row*> drawn_;
  std::vector<std::string> families_;
  Decades x_, y_;
};

}  // namespace

std::string DrawFigure(const StudyResult& study) {
  return Figure(study).Draw();
}

}  // namespace palpate
