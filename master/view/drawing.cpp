#include "master/view/drawing.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace palpate {
namespace {

// A tenth of a pixel is finer than an eye; beyond 1e5 pixels nothing is seen.
std::string Pixels(double value) {
  constexpr double kFarthest = 1e5;
  std::array<char, 32> text{};
  const double shown =
      std::isfinite(value) ? std::fmax(-kFarthest, std::fmin(kFarthest, value)) : 0;
  std::snprintf(text.data(), text.size(), "%.1f", shown);
  return text.data();
}

// What XML reads as its own, and what no XML may contain, made harmless.
std::string Harmless(std::string_view words) {
  std::string text;
  for (const char c : words) {
    switch (c) {
      case '&':
        text += "&amp;";
        break;
      case '<':
        text += "&lt;";
        break;
      case '"':
        text += "&quot;";
        break;
      default:
        text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return text;
}

}  // namespace

Drawing::Drawing(double width, double height, std::string_view title, std::string_view style) {
  text_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\"";
  Attribute("width", width);
  Attribute("height", height);
  Attribute("viewBox", "0 0 " + Pixels(width) + " " + Pixels(height));
  text_.append(">\n<title>").append(Harmless(title)).append("</title>\n<style>\n");
  text_.append(style).append("</style>\n");
}

void Drawing::Polygon(std::span<const Eigen::Vector2d> corners, std::string_view colour) {
  text_ += "<polygon class=\"face\"";
  Attribute("fill", colour);
  Attribute("stroke", colour);
  Corners(corners);
}

void Drawing::Shape(std::span<const Eigen::Vector2d> corners, std::string_view style_class) {
  text_ += "<polygon";
  Attribute("class", style_class);
  Corners(corners);
}

void Drawing::Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                   std::string_view style_class) {
  text_ += "<line";
  Attribute("class", style_class);
  Attribute("x1", a.x());
  Attribute("y1", a.y());
  Attribute("x2", b.x());
  Attribute("y2", b.y());
  text_ += "/>\n";
}

void Drawing::Circle(const Eigen::Vector2d& centre, double radius, std::string_view style_class) {
  text_ += "<circle";
  Attribute("class", style_class);
  Attribute("cx", centre.x());
  Attribute("cy", centre.y());
  Attribute("r", radius);
  text_ += "/>\n";
}

void Drawing::Text(const Eigen::Vector2d& at, std::string_view words, std::string_view style_class,
                   Anchor anchor) {
  constexpr std::array<std::string_view, 3> kAnchors{"start", "middle", "end"};
  text_ += "<text";
  Attribute("class", style_class);
  Attribute("x", at.x());
  Attribute("y", at.y());
  Attribute("text-anchor", kAnchors[static_cast<std::size_t>(anchor)]);
  text_.append(">").append(Harmless(words)).append("</text>\n");
}

void Drawing::BeginGroup(std::string_view style_class) {
  text_ += "<g";
  Attribute("class", style_class);
  text_ += ">\n";
}

void Drawing::Corners(std::span<const Eigen::Vector2d> corners) {
  text_ += " points=\"";
  for (const Eigen::Vector2d& corner : corners) {
    text_.append(Pixels(corner.x())).append(",").append(Pixels(corner.y())).append(" ");
  }
  if (!corners.empty()) text_.pop_back();
  text_ += "\"/>\n";
}

void Drawing::Attribute(std::string_view name, std::string_view value) {
  text_.append(" ").append(name).append("=\"").append(Harmless(value)).append("\"");
}

void Drawing::Attribute(std::string_view name, double value) {
  Attribute(name, Pixels(value));
}

}  // namespace palpate
