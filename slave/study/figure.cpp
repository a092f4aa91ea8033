#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "shared/text/svg.h"
#include "shared/text/text.h"
#include "slave/study/report.h"

namespace palpate::study {
namespace {

using Eigen::Vector2d;
using Points = std::vector<Vector2d>;

constexpr double kWidth = 1060, kHeight = 520;
constexpr double kTop = 62, kBottom = 462, kLegend = 864;
// Beyond them nothing is drawn to scale.
constexpr double kSmallestError = 1e-8, kLargestError = 1e3;
constexpr double kShortest = 1e-9, kLongest = 1e5;  // [s]

constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 12px; }
.paper { fill: #ffffff; }
.ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 16px; font-weight: 600; } .small { font-size: 11px; }
.grid { stroke: #d9dee6; stroke-width: 1; } .frame { fill: none; stroke: #8a94a6; }
.target { fill: #2f9e62; fill-opacity: 0.12; stroke: #2f9e62; stroke-dasharray: 4 3; }
.front { fill: none; stroke: #5b6576; stroke-width: 1.5; stroke-dasharray: 7 3; }
.leader { stroke: #8a94a6; stroke-width: 0.8; }
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
const Vector2d kMark(6.5, 6.5);  // half of what a mark needs [px]

bool IsDrawn(const StudyRow& row) {
  return row.outcome == Outcome::kAnswered && std::isfinite(row.error.value) &&
         row.update_median_s > 0;
}

// A logarithmic axis a little wider than its values.
struct Axis {
  double low = 0, high = 0;  // decades
  static Axis Around(const std::vector<double>& values) {
    constexpr double kLeast = 0.7, kMargin = 0.07;
    const auto [least, most] = std::ranges::minmax(values);
    const double middle = 0.5 * (std::log10(least) + std::log10(most));
    const double half = std::max(0.5 * kLeast, (0.5 + kMargin) * std::log10(most / least));
    return {middle - half, middle + half};
  }
  [[nodiscard]] double Share(double value) const {
    return std::clamp((std::log10(value) - low) / (high - low), 0.0, 1.0);
  }
  // Far enough apart for their words.
  [[nodiscard]] std::vector<double> Ticks() const {
    constexpr double kFew = 2, kMany = 7;
    const double span = high - low;
    std::vector<double> ticks;
    for (int d = static_cast<int>(std::floor(low)); d <= high; ++d) {
      if (span > kMany && d % 2 != 0) continue;
      for (const double part : {1.0, 2.0, 5.0}) {
        const double at = d + std::log10(part);
        const bool is_shown = part == 1 || span <= kFew;
        if (is_shown && at >= low && at <= high) ticks.push_back(part * std::pow(10, d));
      }
    }
    return ticks;
  }
};

// Seconds with a readable unit.
std::string Seconds(double s) {
  if (s >= 0.999) return Formatted("%g s", s);
  if (s >= 0.999e-3) return Formatted("%g ms", 1e3 * s);
  if (s >= 0.999e-6) return Formatted("%g us", 1e6 * s);
  return Formatted("%g ns", 1e9 * s);
}

// Rectangles that are taken, by words and marks.
class Taken {
 public:
  [[nodiscard]] bool IsFree(const Vector2d& corner, const Vector2d& size) const {
    return std::ranges::none_of(boxes_, [&](const auto& box) {
      return (corner.array() < box.second.array()).all() &&
             (box.first.array() < (corner + size).array()).all();
    });
  }
  void Add(const Vector2d& corner, const Vector2d& size) {
    boxes_.emplace_back(corner, corner + size);
  }

 private:
  std::vector<std::pair<Vector2d, Vector2d>> boxes_;
};

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
  struct Shape {
    int corners;
    double radius, inner, turn;
  };
  constexpr std::array<Shape, 5> kShapes{{{4, 6.4, 1, kQuarter},
                                          {3, 6.6, 1, 0},
                                          {4, 6.4, 1, 0},
                                          {3, 6.6, 1, std::numbers::pi},
                                          {5, 7.4, 0.45, 0}}};
  if (family % 6 == 0) return svg->Circle(at, 5, style, tooltip);
  const auto& [corners, radius, inner, turn] = kShapes[family % 6 - 1];
  svg->Polygon(Star(at, corners, radius, inner, turn), style, tooltip);
}

std::string Tooltip(const StudyRow& row) {
  return row.name() + Formatted(": error %.3g %% (+- %.2g %%), update %.3g us, precompute %.3g s",
                                100 * row.error.value, 100 * row.error.bar,
                                1e6 * row.update_median_s, row.precompute_s);
}

// Error over one cost.
struct Panel {
  double left = 0, right = 0;  // [px]
  std::string_view caption;
  double StudyRow::*cost = nullptr;  // [s]
  Axis axis;

  [[nodiscard]] double X(double seconds) const {
    return left + (right - left) * axis.Share(seconds);
  }
  [[nodiscard]] double middle() const { return 0.5 * (left + right); }
};

class Figure {
 public:
  explicit Figure(const StudyResult& study)
      : study_(study),
        svg_(kWidth, kHeight, "Speed against accuracy: " + study.scene_name, kStyle) {
    std::vector<double> errors{study.tolerance};
    for (const StudyRow& row : study.rows) {
      if (!IsDrawn(row)) continue;
      drawn_.push_back(&row);
      errors.push_back(std::clamp(row.error.value, kSmallestError, kLargestError));
      if (std::ranges::find(families_, row.family) == families_.end()) {
        families_.push_back(row.family);
      }
    }
    std::ranges::sort(families_);
    errors_ = Axis::Around(errors);
    update_.axis = AxisOf(update_);
    precompute_.axis = AxisOf(precompute_);
  }

  std::string Draw() {
    svg_.Rectangle({0, 0}, {kWidth, kHeight}, "paper");
    svg_.Text({update_.left, 26}, study_.scene_name + ": speed against accuracy", "ink heading");
    svg_.Text({update_.left, 46}, "recommended: " + study_.recommendation, "soft small");
    svg_.Text({18, 0.5 * (kTop + kBottom)}, "error of the contact force", "ink",
              Svg::Anchor::kMiddle, -90);
    for (const Panel& panel : {update_, precompute_}) {
      DrawTarget(panel);
      DrawAxes(panel);
      DrawFront(panel);
      DrawRows(panel);
    }
    DrawLegend();
    return svg_.Document();
  }

 private:
  // The rate that is asked for belongs to it only where some model misses it: it may be far off.
  [[nodiscard]] Axis AxisOf(const Panel& panel) const {
    std::vector<double> costs;
    for (const StudyRow* row : drawn_) {
      costs.push_back(std::clamp(row->*panel.cost, kShortest, kLongest));
    }
    if (costs.empty()) return {-3, 0};
    const double wanted = 1 / study_.rate;
    if (panel.cost == update_.cost && wanted < std::ranges::max(costs)) costs.push_back(wanted);
    return Axis::Around(costs);
  }

  [[nodiscard]] double Y(double error) const {
    return kBottom -
           (kBottom - kTop) * errors_.Share(std::clamp(error, kSmallestError, kLargestError));
  }
  [[nodiscard]] Vector2d At(const Panel& panel, const StudyRow& row) const {
    return {panel.X(row.*panel.cost), Y(row.error.value)};
  }

  void DrawAxes(const Panel& panel) {
    for (const double seconds : panel.axis.Ticks()) {
      const double x = panel.X(seconds);
      svg_.Line({x, kTop}, {x, kBottom}, "grid");
      svg_.Text({x, kBottom + 18}, Seconds(seconds), "soft small", Svg::Anchor::kMiddle);
    }
    for (const double error : errors_.Ticks()) {
      const double y = Y(error);
      svg_.Line({panel.left, y}, {panel.right, y}, "grid");
      if (panel.cost != update_.cost) continue;
      svg_.Text({panel.left - 8, y + 4}, Formatted("%g %%", 100 * error), "soft small",
                Svg::Anchor::kEnd);
    }
    svg_.Rectangle({panel.left, kTop}, {panel.right - panel.left, kBottom - kTop}, "frame");
    svg_.Text({panel.middle(), kBottom + 40}, panel.caption, "ink", Svg::Anchor::kMiddle);
  }

  // What the scene asks for; precompute may take as long as it likes.
  void DrawTarget(const Panel& panel) {
    const bool is_update = panel.cost == update_.cost;
    const Vector2d corner(panel.left, Y(study_.tolerance));
    const double right = is_update ? panel.X(1 / study_.rate) : panel.right;
    svg_.Rectangle(corner, Vector2d(right, kBottom) - corner, "target");
    if (!is_update) return;
    svg_.Text({panel.left + 8, kBottom - 8},
              Formatted("requested: %g %% at %g Hz", 100 * study_.tolerance, study_.rate),
              "soft small");
  }

  // A staircase: what is reachable lies above and to the right of it.
  void DrawFront(const Panel& panel) {
    std::vector<const StudyRow*> sorted = drawn_;
    std::ranges::sort(sorted, {}, [&](const StudyRow* row) {
      return std::pair(row->*panel.cost, row->error.value);
    });
    Points points;
    double least = std::numeric_limits<double>::infinity();
    for (const StudyRow* row : sorted) {
      if (row->error.value >= least) continue;
      least = row->error.value;
      const Vector2d at = At(panel, *row);
      if (!points.empty()) points.emplace_back(at.x(), points.back().y());
      points.push_back(at);
    }
    if (!points.empty()) points.emplace_back(panel.right, points.back().y());
    svg_.Polyline(points, "front");
  }

  // Marks that would hide each other go beside their place, to which a line leads; words stand
  // where neither they nor marks are. What is not dominated is named, as far as there is room.
  void DrawRows(const Panel& panel) {
    Taken taken;
    std::vector<std::pair<const StudyRow*, Vector2d>> marks;
    for (const StudyRow* row : drawn_) {
      const Vector2d at = At(panel, *row), mark = BesideOthers(panel, at, taken);
      taken.Add(mark - kMark, 2 * kMark);
      marks.emplace_back(row, mark);
      const auto family =
          static_cast<std::size_t>(std::ranges::find(families_, row->family) - families_.begin());
      const std::string style = "bar c" + std::to_string(family % kColours);
      svg_.Line({mark.x(), Y(row->error.value + row->error.bar)},
                {mark.x(), Y(row->error.value - row->error.bar)}, style);
      if (mark != at) svg_.Line(at, mark, "leader");
      Mark(&svg_, family, mark, Tooltip(*row));
      if (row->recommended) svg_.Circle(mark, 11, "choice");
    }
    std::ranges::stable_sort(marks, {}, [](const auto& one) { return !one.first->recommended; });
    for (const auto& [row, mark] : marks) {
      if (row->recommended || row->on_front) Name(panel, *row, mark, &taken);
    }
  }

  [[nodiscard]] static Vector2d BesideOthers(const Panel& panel, const Vector2d& at,
                                             const Taken& taken) {
    constexpr int kSteps = 12;
    const double step = 2 * kMark.x();
    for (int i = 0; i <= 2 * kSteps; ++i) {
      const double aside = step * ((i + 1) / 2) * (i % 2 == 0 ? 1 : -1);
      const Vector2d mark = at + Vector2d(aside, 0);
      const bool inside = mark.x() >= panel.left && mark.x() <= panel.right;
      if (inside && taken.IsFree(mark - kMark, 2 * kMark)) return mark;
    }
    return at;
  }

  void Name(const Panel& panel, const StudyRow& row, const Vector2d& mark, Taken* taken) {
    constexpr double kLetter = 6.2, kLine = 12, kGap = 12;  // of small words [px]
    const std::string words = row.recommended ? row.name() : row.resolution;
    const Vector2d size(kLetter * static_cast<double>(words.size()), kLine);
    for (const double up : {-6.0, -22.0, 10.0, -38.0, 26.0, -54.0, 42.0}) {
      for (const double left : {kGap, -kGap - size.x(), -0.5 * size.x()}) {
        const Vector2d corner = mark + Vector2d(left, up);
        const bool inside = corner.x() >= panel.left && corner.x() + size.x() <= panel.right &&
                            corner.y() >= kTop && corner.y() + size.y() <= kBottom - 2 * kLine;
        if (!inside || !taken->IsFree(corner, size)) continue;
        taken->Add(corner, size);
        svg_.Text(corner + Vector2d(0, kLine - 2), words,
                  row.recommended ? "choice-ink small" : "soft small");
        return;
      }
    }
  }

  void DrawLegend() {
    double y = kTop + 10;
    for (std::size_t f = 0; f < families_.size(); ++f, y += 22) {
      Mark(&svg_, f, {kLegend + 10, y}, {});
      svg_.Text({kLegend + 24, y + 4}, families_[f], "ink");
    }
    svg_.Line({kLegend, y}, {kLegend + 20, y}, "front");
    svg_.Text({kLegend + 24, y + 4}, "not dominated", "soft");
    svg_.Circle({kLegend + 10, y + 24}, 8, "choice");
    svg_.Text({kLegend + 24, y + 28}, "recommended", "soft");
  }

  const StudyResult& study_;
  Svg svg_;
  std::vector<const StudyRow*> drawn_;
  std::vector<std::string> families_;
  Axis errors_;
  Panel update_{74, 430, "update time of a moved contact (median)", &StudyRow::update_median_s, {}};
  Panel precompute_{482, 838, "precompute time (once)", &StudyRow::precompute_s, {}};
};

}  // namespace

std::string DrawFigure(const StudyResult& study) {
  return Figure(study).Draw();
}

}  // namespace palpate::study
