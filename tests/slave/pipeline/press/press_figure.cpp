#include "tests/slave/pipeline/press/press_figure.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "shared/text/svg.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kWidth = 1180, kHeight = 470;
constexpr double kFirstFrame = 54, kLastFrame = 96, kMostForce = 6;
constexpr double kMostWay = 5e-3;
constexpr int kShades = 24;

std::string Style() {
  std::string style = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 12px; }
.paper { fill: #ffffff; } .ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 15px; font-weight: 600; }
.grid { stroke: #d9dee6; } .train { fill: #eef3fb; }
.wrench { fill: none; stroke: #8a94a6; stroke-width: 1.5; }
.bar { stroke: #2f6fd6; stroke-width: 1.2; } .estimate { fill: #2f6fd6; }
.contact { fill: none; stroke: #1d2430; stroke-width: 1.5; }
)";
  // Inwards blue, outwards orange, white at rest.
  for (int k = -kShades; k <= kShades; ++k) {
    const double share = std::sqrt(std::abs(k) / static_cast<double>(kShades));
    const Eigen::Vector3d full =
        k < 0 ? Eigen::Vector3d(20, 70, 170) : Eigen::Vector3d(215, 90, 10);
    const Eigen::Vector3d colour = (1 - share) * Eigen::Vector3d(246, 246, 246) + share * full;
    style += fmt::format(".w{} {{ fill: rgb({:.0f}, {:.0f}, {:.0f}); }}\n", k + kShades, colour.x(),
                         colour.y(), colour.z());
  }
  return style;
}

std::string Shade(double way) {
  const double scaled = std::clamp(way / kMostWay, -1.0, 1.0);
  return fmt::format("w{}", static_cast<int>(std::lround(scaled * kShades)) + kShades);
}

void DrawForces(const PressFigure& figure, Svg* svg) {
  const auto at = [](double frame, double force) {
    return Vector2d(60 + 460 * (frame - kFirstFrame) / (kLastFrame - kFirstFrame),
                    400 - 320 * force / kMostForce);
  };
  const Vector2d corner = at(kFirstFrame, kMostForce);
  const Vector2d end = at(figure.last_training_frame + 0.5, 0);
  svg->Rectangle(corner, end - corner, "train");
  svg->Text(corner + Vector2d(6, 16), "identified on these", "soft");
  for (int force = 0; force <= kMostForce; ++force) {
    svg->Line(at(kFirstFrame, force), at(kLastFrame, force), "grid");
    svg->Text(at(kFirstFrame, force) + Vector2d(-8, 4), fmt::format("{} N", force), "soft",
              Svg::Anchor::kEnd);
  }
  for (int frame = 55; frame <= kLastFrame; frame += 5) {
    svg->Text(at(frame, 0) + Vector2d(0, 18), fmt::format("{}", frame), "soft",
              Svg::Anchor::kMiddle);
  }
  svg->Text(at(75, 0) + Vector2d(0, 38), "frame, 30 a second", "soft", Svg::Anchor::kMiddle);
  std::vector<Vector2d> line;
  for (std::size_t k = 0; k < figure.wrench.size(); ++k) {
    const auto frame = static_cast<double>(k);
    if (frame >= kFirstFrame && frame <= kLastFrame) {
      line.push_back(at(frame, std::min(figure.wrench[k], kMostForce)));
    }
  }
  svg->Polyline(line, "wrench");
  for (const auto& force : figure.forces) {
    svg->Line(at(force.frame, force.estimated - force.sigma),
              at(force.frame, force.estimated + force.sigma), "bar");
    svg->Circle(at(force.frame, force.estimated), 3.5, "estimate",
                fmt::format("frame {}: {:.2f} N, wrench {:.2f} N", force.frame, force.estimated,
                            force.measured));
  }
  svg->Text({225, 384}, "grey: wrench, blue: from the depth picture", "soft");
}

void DrawField(const PressFigure& figure, bool explained, const Vector2d& corner, Svg* svg) {
  constexpr double kScale = 0.46;
  svg->Text(corner + Vector2d(0, -8),
            fmt::format("frame {}, {}", figure.field_frame, explained ? "explained" : "measured"),
            "ink");
  for (const auto& way : figure.field) {
    svg->Rectangle(corner + kScale * (way.place - Vector2d(8, 8)),
                   Vector2d::Constant(kScale * 16.2),
                   Shade(explained ? way.explained : way.measured));
  }
  svg->Circle(corner + kScale * figure.contact, 6, "contact");
}

}  // namespace

std::string Drawn(const PressFigure& figure) {
  Svg svg(kWidth, kHeight, figure.title, Style());
  svg.Rectangle({0, 0}, {kWidth, kHeight}, "paper");
  svg.Text({24, 30}, figure.title, "heading ink");
  svg.Text({24, 50}, figure.remark, "soft");
  DrawForces(figure, &svg);
  DrawField(figure, false, {560, 90}, &svg);
  DrawField(figure, true, {870, 90}, &svg);
  // The scale of the ways.
  for (int k = -kShades; k <= kShades; ++k) {
    svg.Rectangle({740 + 5.0 * k, 350}, {5.2, 14}, fmt::format("w{}", k + kShades));
  }
  svg.Text({740, 384},
           fmt::format("{:.0f} mm inwards to {:.0f} mm outwards along the normal", 1e3 * kMostWay,
                       1e3 * kMostWay),
           "soft", Svg::Anchor::kMiddle);
  return svg.Document();
}

}  // namespace palpate
