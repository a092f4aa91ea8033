#include "slave/report/svg.h"

#include <array>
#include <cmath>

#include "shared/text/text.h"

namespace palpate {
namespace {

// Rounds to a tenth of a pixel, within 1e5 pixels.
std::string Pixels(double value) {
  constexpr double kFarthest = 1e5;
  const double shown =
      std::isfinite(value) ? std::fmax(-kFarthest, std::fmin(kFarthest, value)) : 0;
  return Formatted("%.1f", shown);
}

}  // namespace

Svg::Svg(double width, double height, std::string_view title, std::string_view style) {
  body_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\"";
  Add("width", width);
  Add("height", height);
  Add("viewBox", "0 0 " + Pixels(width) + " " + Pixels(height));
  body_.append(">\n<title>").append(XmlEscaped(title)).append("</title>\n<style>\n");
  body_.append(style).append("</style>\n");
}

void Svg::Open(std::string_view element, std::string_view style_class) {
  body_.append("<").append(element);
  Add("class", style_class);
}

void Svg::Add(std::string_view name, std::string_view value) {
  body_.append(" ").append(name).append("=\"").append(XmlEscaped(value)).append("\"");
}

void Svg::Add(std::string_view name, double value) {
  Add(name, Pixels(value));
}

void Svg::AddPoints(std::span<const Eigen::Vector2d> points) {
  std::string text;
  for (const auto& p : points) {
    text.append(text.empty() ? "" : " ").append(Pixels(p.x())).append(",").append(Pixels(p.y()));
  }
  Add("points", text);
}

void Svg::Close(std::string_view element, std::string_view tooltip) {
  if (tooltip.empty()) {
    body_ += "/>\n";
    return;
  }
  body_.append("><title>").append(XmlEscaped(tooltip)).append("</title></");
  body_.append(element).append(">\n");
}

void Svg::Draw(std::string_view element, std::string_view style_class, Numbers numbers,
               std::string_view tooltip) {
  Open(element, style_class);
  for (const auto& [name, value] : numbers) Add(name, value);
  Close(element, tooltip);
}

void Svg::Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::string_view style_class) {
  Draw("line", style_class, {{"x1", a.x()}, {"y1", a.y()}, {"x2", b.x()}, {"y2", b.y()}});
}

void Svg::Polyline(std::span<const Eigen::Vector2d> points, std::string_view style_class) {
  Open("polyline", style_class);
  AddPoints(points);
  Close("polyline");
}

void Svg::Rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
                    std::string_view style_class) {
  Draw("rect", style_class,
       {{"x", corner.x()}, {"y", corner.y()}, {"width", size.x()}, {"height", size.y()}});
}

void Svg::Circle(const Eigen::Vector2d& centre, double radius, std::string_view style_class,
                 std::string_view tooltip) {
  Draw("circle", style_class, {{"cx", centre.x()}, {"cy", centre.y()}, {"r", radius}}, tooltip);
}

void Svg::Text(const Eigen::Vector2d& at, std::string_view words, std::string_view style_class,
               Anchor anchor, double degrees) {
  constexpr std::array<std::string_view, 3> kAnchors{"start", "middle", "end"};
  Open("text", style_class);
  Add("x", at.x());
  Add("y", at.y());
  Add("text-anchor", kAnchors[static_cast<std::size_t>(anchor)]);
  if (degrees != 0) {
    Add("transform",
        "rotate(" + Pixels(degrees) + " " + Pixels(at.x()) + " " + Pixels(at.y()) + ")");
  }
  body_.append(">").append(XmlEscaped(words)).append("</text>\n");
}

}  // namespace palpate
