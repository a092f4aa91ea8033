#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "shared/text/text.h"
#include "slave/report/svg.h"
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
.choice { fill: none; stroke: #d6336c; stroke-width: 2; }
.mark { stroke-width: 1.5; fill-opacity: 0.75; } .bar { stroke-width: 1.2; fill: none; }
.c0 { fill: #2f6fd6; stroke: #2f6fd6; } .c1 { fill: #e0701c; stroke: #e0701c; }
.c2 { fill: #2f9e62; stroke: #2f9e62; } .c3 { fill: #a64fc9; stroke: #a64fc9; }
.c4 { fill: #c98a00; stroke: #c98a00; } .c5 { fill: #149aa8; stroke: #149aa8; }
.c6 { fill: #d14545; stroke: #d14545; } .c7 { fill: #76808f; stroke: #76808f; }
)";
constexpr double kRadius = 5;  // of a mark [px]

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

  void DrawRows(const Panel& panel) {
    for (const StudyRow* row : drawn_) {
      const Vector2d at = At(panel, *row);
      const std::string colour = ColourOf(row->family);
      svg_.Line({at.x(), Y(row->error.value + row->error.bar)},
                {at.x(), Y(row->error.value - row->error.bar)}, "bar" + colour);
      svg_.Circle(at, kRadius, "mark" + colour, Tooltip(*row));
      if (row->recommended) svg_.Circle(at, 2 * kRadius, "choice");
    }
  }

  [[nodiscard]] std::string ColourOf(const std::string& family) const {
    constexpr int kColours = 8;
    const auto index = std::ranges::find(families_, family) - families_.begin();
    return " c" + std::to_string(index % kColours);
  }

  void DrawLegend() {
    double y = kTop + 10;
    for (const std::string& family : families_) {
      svg_.Circle({kLegend + 10, y}, kRadius, "mark" + ColourOf(family));
      svg_.Text({kLegend + 24, y + 4}, family, "ink");
      y += 22;
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
