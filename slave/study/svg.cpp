#include "slave/study/svg.h"

#include <cstdio>
#include <initializer_list>

namespace palpate {
namespace {

std::string Number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

// With blanks between.
std::string Joined(std::initializer_list<std::string> words) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += ' ';
    text += word;
  }
  return text;
}

std::string Attribute(std::string_view name, std::string_view value) {
  std::string text = " ";
  text.append(name).append("=\"").append(XmlEscaped(value)).append("\"");
  return text;
}

std::string Attribute(std::string_view name, double value) {
  return Attribute(name, Number(value));
}

std::string Points(const std::vector<Eigen::Vector2d>& points) {
  std::string text;
  for (const auto& p : points) {
    if (!text.empty()) text += ' ';
    text.append(Number(p.x())).append(",").append(Number(p.y()));
  }
  return text;
}

}  // namespace

std::string XmlEscaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '&') {
      escaped += "&amp;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else if (static_cast<unsigned char>(c) < 0x20) {
      escaped += ' ';
    } else {
      escaped += c;
    }
  }
  return escaped;
}

Svg::Svg(double width, double height, std::string_view title, std::string_view style) {
  body_ = std::string("<svg xmlns=\"http://www.w3.org/2000/svg\"") + Attribute("width", width) +
          Attribute("height", height) +
          Attribute("viewBox", Joined({"0 0", Number(width), Number(height)})) +
          " role=\"img\">\n<title>" + XmlEscaped(title) + "</title>\n<style>\n";
  body_.append(style).append("</style>\n");
}

void Svg::Close(std::string_view element, std::string_view tooltip) {
  if (tooltip.empty()) {
    body_ += "/>\n";
    return;
  }
  body_.append("><title>").append(XmlEscaped(tooltip)).append("</title></");
  body_.append(element).append(">\n");
}

void Svg::Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::string_view style_class) {
  body_ += std::string("<line") + Attribute("class", style_class) + Attribute("x1", a.x()) +
           Attribute("y1", a.y()) + Attribute("x2", b.x()) + Attribute("y2", b.y());
  Close("line", {});
}

void Svg::Polyline(const std::vector<Eigen::Vector2d>& points, std::string_view style_class) {
  body_ += std::string("<polyline") + Attribute("class", style_class) +
           Attribute("points", Points(points));
  Close("polyline", {});
}

void Svg::Polygon(const std::vector<Eigen::Vector2d>& points, std::string_view style_class,
                  std::string_view tooltip) {
  body_ += std::string("<polygon") + Attribute("class", style_class) +
           Attribute("points", Points(points));
  Close("polygon", tooltip);
}

void Svg::Rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
                    std::string_view style_class) {
  body_ += std::string("<rect") + Attribute("class", style_class) + Attribute("x", corner.x()) +
           Attribute("y", corner.y()) + Attribute("width", size.x()) +
           Attribute("height", size.y());
  Close("rect", {});
}

void Svg::Circle(const Eigen::Vector2d& centre, double radius, std::string_view style_class,
                 std::string_view tooltip) {
  body_ += std::string("<circle") + Attribute("class", style_class) + Attribute("cx", centre.x()) +
           Attribute("cy", centre.y()) + Attribute("r", radius);
  Close("circle", tooltip);
}

void Svg::Text(const Eigen::Vector2d& at, std::string_view words, std::string_view style_class,
               Anchor anchor, double degrees) {
  constexpr const char* kAnchors[] = {"start", "middle", "end"};
  body_ += std::string("<text") + Attribute("class", style_class) + Attribute("x", at.x()) +
           Attribute("y", at.y()) + Attribute("text-anchor", kAnchors[static_cast<int>(anchor)]);
  if (degrees != 0) {
    body_ += Attribute("transform",
                       Joined({"rotate(", Number(degrees), Number(at.x()), Number(at.y()), ")"}));
  }
  body_.append(">").append(XmlEscaped(words)).append("</text>\n");
}

}  // namespace palpate
