#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "shared/text/svg.h"
#include "slave/study/shape/report_words.h"
#include "slave/study/shape/simulated_report.h"

namespace palpate::study {
namespace {

using Eigen::Vector2d;

constexpr double kLeft = 70, kTop = 46, kHeight = 260, kGroup = 130, kBelow = 64;
constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 12px; }
.paper { fill: #ffffff; } .ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 15px; font-weight: 600; }
.grid { stroke: #d9dee6; } .bar { stroke-width: 2; }
.s0 { fill: #2f6fd6; stroke: #2f6fd6; } .s1 { fill: #c98a00; stroke: #c98a00; }
.s2 { fill: #2f9e62; stroke: #2f9e62; }
.rest { fill: none; stroke: #d14545; stroke-width: 1.5; }
)";
constexpr std::array<std::string_view, 3> kClasses{"s0", "s1", "s2"};

// The lowest score, rounded down to the next tenth.
double Floor(const std::vector<SimulatedObject>& objects) {
  double low = 1;
  for (const auto& object : objects) {
    for (const auto& state : object.states) {
      for (const auto& score : state.scores) low = std::min(low, score.octree);
    }
  }
  return std::clamp(std::floor(10 * low) / 10, 0.0, 0.9);
}

}  // namespace

std::string DrawScores(const std::vector<SimulatedObject>& objects) {
  const double width =
      kLeft + kGroup * static_cast<double>(std::max<std::size_t>(objects.size(), 4)) + 20;
  Svg svg(width, kTop + kHeight + kBelow, "Octree scores", kStyle);
  svg.Rectangle({0, 0}, {width, kTop + kHeight + kBelow}, "paper");
  svg.Text({kLeft, 22}, "Octree score by state", "ink heading");
  const double low = Floor(objects);
  const auto y = [&](double share) { return kTop + kHeight * (1 - (share - low) / (1 - low)); };
  for (int i = 0; i <= 5; ++i) {
    const double share = low + (1 - low) * i / 5;
    svg.Line({kLeft, y(share)}, {width - 20, y(share)}, "grid");
    svg.Text({kLeft - 8, y(share) + 4}, Percent(share), "soft", Svg::Anchor::kEnd);
  }
  for (std::size_t k = 0; k < objects.size(); ++k) {
    const double x = kLeft + kGroup * (static_cast<double>(k) + 0.5);
    svg.Text({x, kTop + kHeight + 20}, objects[k].name, "ink", Svg::Anchor::kMiddle);
    svg.Text({x, kTop + kHeight + 36}, objects[k].material, "soft", Svg::Anchor::kMiddle);
    for (std::size_t s = 0; s < 3; ++s) {
      const ShapeState& state = objects[k].states[s];
      const auto [least, most] = std::ranges::minmax(state.scores, {}, &ShapeScore::octree);
      const double at = x + 28 * (static_cast<double>(s) - 1);
      const std::string style(kClasses[s]);
      svg.Line({at, y(least.octree)}, {at, y(most.octree)}, "bar " + style);
      svg.Circle({at, y(state.mean_octree())}, 5, style,
                 state.name + " " + Percent(state.mean_octree()));
    }
    const double rest = std::max(low, objects[k].states[2].mean_undeformed());
    svg.Circle({x + 28, y(rest)}, 5, "rest", "shape at rest " + Percent(rest));
  }
  for (std::size_t s = 0; s < 3 && !objects.empty(); ++s) {
    const Vector2d at(kLeft + 6 + 110 * static_cast<double>(s), kTop + kHeight + 54);
    svg.Circle(at, 5, kClasses[s]);
    svg.Text(at + Vector2d(10, 4), objects[0].states[s].name, "ink");
  }
  const Vector2d at(kLeft + 336, kTop + kHeight + 54);
  svg.Circle(at, 5, "rest");
  svg.Text(at + Vector2d(10, 4), "deformed, against the shape at rest", "ink");
  return svg.Document();
}

}  // namespace palpate::study
