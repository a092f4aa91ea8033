#include "slave/commands/verify/force_figure.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slave/commands/verify/card_words.h"
#include "slave/report/svg.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kWidth = 1100, kPanel = 320, kGap = 40, kMargin = 30, kLine = 20;
constexpr double kTimeHeight = 170;
constexpr std::size_t kMostPoints = 1500;  // in a panel

constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 12px; }
.paper { fill: #ffffff; } .ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 16px; font-weight: 600; }
.frame { fill: none; stroke: #8a94a6; } .equal { stroke: #5b6576; stroke-dasharray: 6 3; }
.point { fill: #2f6fd6; fill-opacity: 0.35; }
.right { fill: #2f9e62; } .wrong { fill: #d14545; font-weight: 600; } .open { fill: #c98a00; }
)";

std::string_view StyleOf(Finding finding) {
  if (finding == Finding::kRight) return "right";
  if (finding == Finding::kWrong) return "wrong";
  return finding == Finding::kOpen ? "open" : "soft";
}

// A rectangle with a range of values on each side.
struct Panel {
  Vector2d corner, size;
  Vector2d low, high;  // of values

  [[nodiscard]] Vector2d Place(double x, double y) const {
    const Vector2d share = (Vector2d(x, y) - low).cwiseQuotient(high - low);
    const Vector2d inside = share.cwiseMax(0).cwiseMin(1);
    return corner + Vector2d(inside.x() * size.x(), (1 - inside.y()) * size.y());
  }
  void DrawFrame(Svg* svg, const std::string& title) const {
    svg->Rectangle(corner, size, "frame");
    svg->Text(corner + Vector2d(4, -6), title, "ink");
    const double bottom = corner.y() + size.y() + 15;
    svg->Text({corner.x(), bottom}, Formatted("%.3g", low.x()), "soft");
    svg->Text({corner.x() + size.x(), bottom}, Formatted("%.3g", high.x()), "soft",
              Svg::Anchor::kEnd);
    svg->Text(corner + Vector2d(4, 14), Formatted("%.3g", high.y()), "soft");
    svg->Text(corner + Vector2d(4, size.y() - 5), Formatted("%.3g", low.y()), "soft");
  }
};

double DrawCard(Svg* svg, const ForceCard& card, double y) {
  for (const CardLine& line : card.lines) {
    svg->Text({kMargin, y}, line.title, "ink");
    svg->Text({kMargin + 130, y}, ToString(line.finding), StyleOf(line.finding));
    svg->Text({kMargin + 220, y}, line.value.empty() ? line.remark : line.value, "ink");
    y += kLine;
  }
  for (const std::string& cause : card.causes) {
    svg->Text({kMargin, y}, "likely wrong: " + cause, "wrong");
    y += kLine;
  }
  return y;
}

void DrawScatter(Svg* svg, const std::vector<MatchedState>& pairs, int axis, Panel panel) {
  double low = 0, high = 0;
  for (const MatchedState& one : pairs) {
    low = std::min({low, one.known.force(axis), one.state.force(axis)});
    high = std::max({high, one.known.force(axis), one.state.force(axis)});
  }
  if (!(high > low)) high = low + 1;
  panel.low = {low, low};
  panel.high = {high, high};
  panel.DrawFrame(svg, std::string("estimated over measured force ") +
                           kAxisNames[static_cast<std::size_t>(axis)] + " [N]");
  svg->Line(panel.Place(low, low), panel.Place(high, high), "equal");
  const std::size_t step = 1 + pairs.size() / kMostPoints;
  for (std::size_t i = 0; i < pairs.size(); i += step) {
    svg->Circle(panel.Place(pairs[i].known.force(axis), pairs[i].state.force(axis)), 2, "point");
  }
}

void DrawErrors(Svg* svg, const ForceCard& card, const std::vector<MatchedState>& pairs,
                Panel panel) {
  const bool has_time = std::isfinite(pairs.front().state.t);
  std::vector<Vector2d> points;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    double squares = 0;
    for (const int axis : card.axes) {
      squares += std::pow(pairs[i].state.force(axis) - pairs[i].known.force(axis), 2);
    }
    points.emplace_back(has_time ? pairs[i].state.t : static_cast<double>(i), std::sqrt(squares));
  }
  panel.low = {points.front().x(), 0};
  panel.high = {std::max(points.back().x(), panel.low.x() + 1e-9), 1e-9};
  for (const Vector2d& point : points) panel.high.y() = std::max(panel.high.y(), point.y());
  panel.DrawFrame(
      svg, has_time ? "size of the error [N] over time [s]" : "size of the error [N] over rows");
  const std::size_t step = 1 + points.size() / kMostPoints;
  for (std::size_t i = 0; i < points.size(); i += step) {
    svg->Circle(panel.Place(points[i].x(), points[i].y()), 2, "point");
  }
}

}  // namespace

std::string DrawForces(const std::string& title, const ForceCard& card,
                       const std::vector<MatchedState>& pairs) {
  const double text_height = kLine * static_cast<double>(card.lines.size() + card.causes.size());
  const double top = 70 + text_height;
  const double height = top + kPanel + 2 * kGap + kTimeHeight;
  Svg svg(kWidth, height, "Forces of " + title, kStyle);
  svg.Rectangle({0, 0}, {kWidth, height}, "paper");
  svg.Text({kMargin, 30}, title + (card.passes() ? ": passes" : ": does not pass"), "ink heading");
  DrawCard(&svg, card, 55);
  for (std::size_t i = 0; i < card.axes.size(); ++i) {
    const double left = kMargin + static_cast<double>(i) * (kPanel + kGap);
    DrawScatter(&svg, pairs, card.axes[i], {{left, top}, {kPanel, kPanel}, {}, {}});
  }
  if (!pairs.empty()) {
    DrawErrors(&svg, card, pairs,
               {{kMargin, top + kPanel + kGap}, {kWidth - 2 * kMargin, kTimeHeight}, {}, {}});
  }
  return svg.Document();
}

}  // namespace palpate
